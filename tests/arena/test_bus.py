"""`play` over the real bus code, emulated servos, and the arena's robot under them: it crawls."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from arena.support import LENGTH, serpenoid_table
from serpenoid.cli.main import main
from serpenoid.gaits.table import write_table

ROOT = Path(__file__).parents[2]
ROBOT_FILE = ROOT / "problems" / "robots" / "snake10-robot.toml"


def command(*words):
    return [sys.executable, "-m", "serpenoid", *map(str, words)]


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="the emulated bus is a pseudo-terminal")
def test_play_moves_the_arenas_robot_head_first(tmp_path):
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
    write_table(tmp_path / "gait.csv", serpenoid_table())
    words = ("robot", "emulate", "--robot", ROBOT_FILE, "--arena", "--motion", tmp_path / "motion.csv")
    emulator = subprocess.Popen(
        command(*words), env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        port = emulator.stdout.readline().strip()
        played = subprocess.run(
            command(
                *("play", tmp_path / "gait.csv", "--robot", ROBOT_FILE, "--port", port, "--log", tmp_path / "log"),
                *("--cycles", 1, "--pause", 0.2, "--cycle-duration", 4),
            ),
            env=environment,
            capture_output=True,
            text=True,
            timeout=60,
        )
    finally:
        emulator.send_signal(signal.SIGINT)
        said = emulator.communicate(timeout=20)
    assert played.returncode == 0, played.stderr
    assert "torque is off" in said[1]
    motion = np.loadtxt(tmp_path / "motion.csv", delimiter=",", skiprows=1)[:, 1:].reshape(-1, 12, 2)
    moved = (motion[-1] - motion[0]).mean(axis=0)
    chord = motion[0, -1] - motion[0, 0]
    assert moved @ chord / np.linalg.norm(chord) > 0.25 * LENGTH


def test_the_arenas_options_belong_together(tmp_path, capsys):
    assert main(["robot", "emulate", "--motion", str(tmp_path / "m.csv")]) == 2
    assert "Add --arena" in capsys.readouterr().err
    assert main(["robot", "emulate", "--arena"]) == 2
    assert "needs --robot" in capsys.readouterr().err
