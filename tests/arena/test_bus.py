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
from serpenoid.table_file import write_table

pytestmark = pytest.mark.usefixtures("serial_ports")

ROOT = Path(__file__).parents[2]
ROBOT_FILE = ROOT / "problems" / "robots" / "snake10-robot.toml"


def command(*words):
    return [sys.executable, "-m", "serpenoid", *map(str, words)]


STARVED = ("no answer", "late", "exchanges")  # how `play` says that the computer was too busy for a bus in real time


def rehearse(folder, table):
    """Emulator in one process, `play` in another; return what play said and the recorded motion."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
    write_table(folder / "gait.csv", table)
    words = ("robot", "emulate", "--robot", ROBOT_FILE, "--arena", "--motion", folder / "motion.csv")
    emulator = subprocess.Popen(
        command(*words), env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        port = emulator.stdout.readline().strip()
        played = subprocess.run(
            command(
                *("play", folder / "gait.csv", "--robot", ROBOT_FILE, "--port", port, "--log", folder / "log"),
                *("--cycles", 1, "--pause", 0.2, "--cycle-duration", 5),
            ),
            env=environment,
            capture_output=True,
            text=True,
            timeout=60,
        )
    finally:
        emulator.send_signal(signal.SIGINT)
        said = emulator.communicate(timeout=20)[1]
    assert "torque is off" in said
    return played, np.loadtxt(folder / "motion.csv", delimiter=",", skiprows=1)[:, 1:].reshape(-1, 12, 2)


GAITS = {
    "reference": serpenoid_table(),
    # what `serpenoid solve problems/snake10.toml --c 1.0` finds: the floor holds joints 6 degrees short of row 0
    "README": serpenoid_table(a=6.579, sigma=0.744, xi=0.815, theta=2.142, centre=(-0.049, 0.077)),
}


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="the emulated bus is a pseudo-terminal")
@pytest.mark.parametrize("gait", [pytest.param("reference", marks=pytest.mark.slow), "README"])
def test_play_moves_the_arenas_robot_head_first(tmp_path, gait):
    for attempt in range(5):  # real time on a computer that others use: the player rightly gives up when starved
        folder = tmp_path / str(attempt)
        folder.mkdir()
        played, motion = rehearse(folder, GAITS[gait])
        if played.returncode == 0 or not any(word in played.stderr for word in STARVED):
            break
    assert played.returncode == 0, played.stderr
    moved = (motion[-1] - motion[0]).mean(axis=0)
    chord = motion[0, -1] - motion[0, 0]
    assert moved @ chord / np.linalg.norm(chord) > 0.2 * LENGTH


def test_the_arenas_options_belong_together(tmp_path, capsys):
    assert main(["robot", "emulate", "--motion", str(tmp_path / "m.csv")]) == 2
    assert "Add --arena" in capsys.readouterr().err
    assert main(["robot", "emulate", "--arena"]) == 2
    assert "needs --robot" in capsys.readouterr().err


def test_the_arenas_robot_has_no_gears(tmp_path, capsys):
    own = Path(__file__).parents[2] / "problems" / "robots" / "snake10-robot.toml"
    (tmp_path / "mine.toml").write_text(
        own.read_text(encoding="utf-8").replace("\nspeed_limit_rpm", "\ngear_ratio = 1.2\nspeed_limit_rpm"),
        encoding="utf-8",
    )
    assert main(["robot", "emulate", "--arena", "--robot", str(tmp_path / "mine.toml")]) == 2
    assert "motors turn its joints directly: leave `gear_ratio` out" in capsys.readouterr().err
