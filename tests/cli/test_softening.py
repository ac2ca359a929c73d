"""What the softening of dry friction changes is said by `simulate`, from a simulation with a tenth of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from serpenoid import load, simulate
from serpenoid.cli.main import main
from specimens import PROBLEMS

COULOMB = ("medium.law='coulomb'", "gait.sigma=0.2")  # back and forth: parts of the body stick


def test_what_softening_changes_is_said_and_is_what_it_changes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [word for value in COULOMB for word in ("--set", value)]
    assert main(["simulate", str(PROBLEMS / "reference.toml"), *words, "--no-figures", "--out", str(tmp_path)]) == 0
    (line,) = (line for line in capsys.readouterr().out.splitlines() if line.startswith("softening"))
    limit = simulate(load(PROBLEMS / "reference.toml", set=[*COULOMB, "medium.softening=1e-4"])).trajectory
    there = simulate(load(PROBLEMS / "reference.toml", set=list(COULOMB))).trajectory
    told = float(line.split(" changes it by ")[1].split()[0])
    assert told == pytest.approx(there.displacement - limit.displacement, rel=0.5)  # a tenth leaves up to a third


def test_linear_drag_has_no_softening_to_speak_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", str(PROBLEMS / "reference.toml"), "--no-figures", "--out", str(tmp_path)]) == 0
    assert "softening" not in capsys.readouterr().out
