"""The site's tutorials are true: their Python runs, block after block, and their commands are commands."""

from __future__ import annotations

import re
import shlex
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import serpenoid as sp
from robot.emulated import start
from serpenoid.cli.main import VERBS, build_parser, main

ROOT = Path(__file__).parents[1]
STARTS = sorted((ROOT / "docs" / "start").glob("*.md")) + sorted((ROOT / "docs" / "how-to").glob("*.md"))


def commands(page: Path) -> list[list[str]]:
    """Every indented `serpenoid ...` line of a page, as words."""
    lines = re.findall(r"^    serpenoid (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return [shlex.split(line, comments=True) for line in lines]


@pytest.mark.parametrize("page", STARTS, ids=lambda path: path.stem)
def test_commands_of_a_tutorial_are_understood(page: Path) -> None:
    parser = build_parser(*VERBS)
    for words in commands(page):
        parser.parse_args(words)
        named = [word for word in words if word.startswith("problems/")]
        assert all((ROOT / name).exists() for name in named), words


def python_tutorial() -> dict[str, Any]:
    """Run it; what it has named."""
    assert main(["examples"]) == 0
    text = (ROOT / "docs" / "start" / "python.md").read_text(encoding="utf-8")
    names: dict[str, Any] = {}
    for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        exec(compile(block, "python.md", "exec"), names)
    return names


def test_the_tutorials_curvature_is_what_small_loops_move_per_area(tmp_path: Path) -> None:
    names = python_tutorial()
    middle, t = names["table"][0], 2 * np.pi * np.arange(400) / 400
    curvature = np.array(names["curvature"](middle)).ravel()
    errors = []
    for radius in (0.04, 0.02):
        loop = np.tile(middle, (len(t), 1))
        loop[:, [names["i"], names["j"]]] += radius * np.column_stack([np.cos(t), np.sin(t)])
        moved = sp.simulate_joint_angles(names["problem"].model, loop).net_motion
        errors.append(np.abs(moved / (np.pi * radius**2) - curvature).max())
    assert np.abs(curvature).max() > 500 * errors[0]
    assert 1.7 < errors[0] / errors[1] < 2.3  # what is left is of first order in the radius


def test_the_python_tutorial_runs(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    python_tutorial()
    said = capsys.readouterr().out
    assert "<Simulation reference: solved" in said
    assert "SOLVED 0.0" in said


def test_the_robot_tutorial_plays_and_measures_on_emulated_servos(
    tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    """Every command but the last, `diagnose`; the film is the answer's own motion, a row of the table every 60 ms."""
    servos: list[subprocess.Popen[str]] = []
    page = commands(ROOT / "docs" / "start" / "robot.md")
    try:
        for words in page[: [w[0] for w in page].index("diagnose")]:
            if words[:2] == ["robot", "emulate"]:
                servos.append(start(*words))
                while not Path("port").exists():
                    assert servos[0].poll() is None
                    time.sleep(0.05)
                continue
            if words[:2] == ["campaign", "add"]:
                film(Path("FILM.csv"))
            assert main([*words, *(["--no-figures"] if words[0] in ("solve", "measure") else [])]) == 0, words
    finally:
        for process in servos:
            process.send_signal(signal.SIGINT)
            assert "0 rejected" in "".join(process.communicate(timeout=60))
    said = capsys.readouterr().out
    for words in ("6 joints may be played", "ID  16", "done: played to the end", "trial `first` added", "0.48 m long"):
        assert words in said, words


def film(path: Path) -> None:
    """The optimum's motion as cameras would give it: half a second at rest before and after, in metres."""
    rows = np.genfromtxt("gait/trajectory.csv", delimiter=",", names=True)
    points = 0.48 * np.stack([rows[f"{axis}_{k}"] for k in range(8) for axis in "xy"], axis=1)
    at = np.concatenate([np.zeros(8, int), np.arange(len(points)), np.full(8, len(points) - 1)])
    header = "t_s," + ",".join(f"x_{k},y_{k}" for k in range(8))
    table = np.column_stack([0.06 * np.arange(len(at)), points[at]])
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.6f")


def test_the_animal_tutorial_measures_its_example(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    assert main(["examples"]) == 0
    measure = next(words for words in commands(ROOT / "docs" / "start" / "animal.md") if words[0] == "measure")
    assert main([*measure, "--no-figures", "--out", "measured"]) == 0
    assert "vertices" in capsys.readouterr().out
