"""Words about numbers: one thing is no several things, wherever a command counts."""

from __future__ import annotations

from pathlib import Path

import pytest

from serpenoid.cli.main import main
from serpenoid.wording import counted, percent, up_to


def test_one_of_a_kind_has_no_plural() -> None:
    assert [counted(n, "joint") for n in (0, 1, 2)] == ["0 joints", "1 joint", "2 joints"]


def test_a_body_of_one_joint_and_a_sweep_of_one_point_are_told_as_such(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    body = "[body]\nvertices = 3\n[medium]\nanisotropy_ratio = 0.2\n"
    (tmp_path / "one.toml").write_text(body + "[gait]\na = 3.0\n", encoding="utf-8")
    assert main(["simulate", str(tmp_path / "one.toml"), "--no-figures", "--out", str(tmp_path / "one")]) == 0
    assert main(["show", str(tmp_path / "one")]) == 0
    assert "3 vertices, 1 joint, 1 m" in capsys.readouterr().out
    (tmp_path / "two.toml").write_text(body.replace("3", "4") + "[task]\nsteps = 30\n", encoding="utf-8")
    words = ["sweep", str(tmp_path / "two.toml"), "--c", "5", "--starts", "1", "--no-figures"]
    assert main([*words, "--out", str(tmp_path / "two")]) == 0
    assert "two: 1 point solved, 0 failed" in capsys.readouterr().out


def test_percentages_have_no_power_of_ten_and_small_numbers_are_no_zero() -> None:
    assert [percent(share) for share in (0.00612, 0.1234, 0.996, 12.34)] == ["0.61 %", "12 %", "100 %", "1234 %"]
    assert [up_to(most, "°") for most in (70.04, 0.05, 0.01, 0.0)] == ["up to 70.0°", "up to 0.1°", *["below 0.1°"] * 2]
