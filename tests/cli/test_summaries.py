"""Summaries say of what a number is: of how many cycles, in which unit, of which mesh, under which limit."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from serpenoid.cli.main import main
from serpenoid.cli.sweep import _lines, _mesh_lines

BODY = "[body]\nvertices = 4\nlength_m = 0.5\n"
MEDIUM = "[medium]\nanisotropy_ratio = 0.2\n"
SMALL = "--set", "task.steps=12", "--no-figures"


def written(folder: Path, text: str) -> str:
    """A problem file."""
    path = folder / "asked.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def said(capsys: pytest.CaptureFixture[str]) -> dict[str, str]:
    """Lines of a summary by their first 18 characters."""
    lines = capsys.readouterr().out.splitlines()
    return {line[:18].strip(): line[18:] for line in lines}


def number(words: str) -> float:
    """The first word."""
    return float(words.split()[0])


def test_numbers_of_several_cycles_say_so_and_speed_is_per_cycle_and_per_second(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = written(tmp_path, BODY + MEDIUM + "[task]\ncycle_duration_s = 4.0\n")
    runs = []
    for cycles in (1, 3):
        assert (
            main(
                ["simulate", asked, *SMALL, "--set", f"task.cycles={cycles}", "--out", str(tmp_path / "out"), "--force"]
            )
            == 0
        )
        runs.append(said(capsys))
    one, three = runs
    assert number(three["dissipation T*E"]) == pytest.approx(3 * number(one["dissipation T*E"]), rel=1e-5)
    for name in ("displacement", "dissipation T*E", "heading change", "forward part"):
        assert "in 3 cycles" in three[name]
        assert "cycle" not in one[name]
    assert three["mesh"] == f"one cycle: {one['mesh']}"
    far = number(one["displacement"])
    told = [float(part.split()[0]) for part in one["speed"].split(", ")]  # m per cycle, body lengths/s, m/s
    assert told == pytest.approx([0.5 * far, far / 4, 0.5 * far / 4], rel=1e-3)
    assert main(["show", str(tmp_path / "out")]) == 0
    shown = said(capsys)
    assert "in 3 cycles" in shown["displacement"]
    assert "in 3 cycles" in shown["dissipation T*E"]


def test_without_length_and_duration_there_is_no_speed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = written(tmp_path, "[body]\nvertices = 4\n" + MEDIUM)
    assert main(["simulate", asked, *SMALL, "--out", str(tmp_path / "out")]) == 0
    assert "speed" not in said(capsys)


def test_a_goal_that_is_met_beside_a_coarse_mesh_is_said_to_be_met_with_those_steps(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = written(tmp_path, BODY + MEDIUM + '[[task.demands]]\nkind = "travel"\nleast = 0.01\n')
    assert main(["simulate", asked, *SMALL, "--out", str(tmp_path / "out")]) == 0
    out = capsys.readouterr().out
    assert "the same gait with many steps" in out
    assert (
        "goals are met with 12 steps; with many the same gait may miss them by this error: --set task.steps=48" in out
    )


def test_a_speed_limit_that_does_not_hold_is_told_even_where_all_else_is_quiet(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = written(tmp_path, BODY + "joint_speed_limit_rpm = 5\n" + MEDIUM)
    quiet = ["simulate", asked, *SMALL, "--quiet", "--force", "--out", str(tmp_path / "out")]
    assert main(quiet) == 0
    assert "joint_speed_limit_rpm = 5 does not hold: without `cycle_duration_s`" in capsys.readouterr().err
    assert main([*quiet, "--set", "task.cycle_duration_s=4.0"]) == 0
    assert "does not hold" not in capsys.readouterr().err


def test_of_what_cannot_be_met_together_the_parts_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A body that bends by no more than 10 degrees has no gait of amplitude 12."""
    limited = BODY.replace("vertices = 4", "vertices = 4\njoint_limit_deg = 10")
    asked = written(tmp_path, limited + MEDIUM + "[task.bounds]\na = [12.0, 15.0]\n")
    assert main(["solve", asked, *SMALL, "--starts", "1", "--out", str(tmp_path / "out")]) == 1
    said = capsys.readouterr().err
    assert "degrees, its limit is 10; " in said
    assert "a = 12, a bound" in said


@pytest.mark.parametrize("verb", ["simulate", "solve"])
def test_a_joint_table_that_is_not_there_is_told_with_the_file_and_key_that_name_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], verb: str
) -> None:
    asked = written(tmp_path, BODY + MEDIUM + '[gait]\npath = "nope.csv"\n')
    assert main([verb, asked, "--out", str(tmp_path / "out")]) == 2
    assert f"{asked}: [gait] path: {tmp_path / 'nope.csv'}: no such file." in capsys.readouterr().err


def test_a_parameter_that_is_nothing_has_no_sign() -> None:
    from serpenoid.gaits import EllipseGait

    assert "x_c 0.0000" in EllipseGait(x_c=-1e-9).words


@pytest.mark.parametrize("verb", ["simulate", "sweep"])
def test_a_model_with_another_body_says_so_and_one_without_does_not(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], verb: str
) -> None:
    asked, model = written(tmp_path, BODY + MEDIUM), tmp_path / "five.toml"
    few = ["--c", "0.5,0.6", "--starts", "1", "--no-polish"] if verb == "sweep" else []
    words = [verb, asked, *SMALL, *few, "--model", str(model), "--out", str(tmp_path / "out"), "--force"]
    for body, note in (
        (
            BODY.replace("vertices = 4", "vertices = 5"),
            "4 vertices, 0.5 m -> 5 vertices, 0.5 m; it differs in vertices, ",
        ),
        (
            "[body]\nvertices = 4\nedge_lengths = [0.1, 0.2, 0.2]\nweights = [1, 2, 2, 1]\n",
            "; it differs in edge lengths and weights.",
        ),
        ("[body]\nvertices = 4\nlength_m = 0.5\nmass_kg = 1.0\n", "; it differs in mass."),
        ("[body]\nvertices = 4\nedge_lengths = [0.16666666667, 0.16666666667, 0.16666666667]\n", None),
        ("", None),
    ):
        model.write_text(MEDIUM + body, encoding="utf-8")
        assert main([*words, "--json", "--quiet"]) in (0, 1)  # 12 steps are few for some
        captured = capsys.readouterr()
        record = json.loads(captured.out)
        record = record[0] if verb == "sweep" else record
        assert (note is not None) == ("the body is that of five.toml, not the problem's" in captured.err)
        assert (record.get("body_note") is None) == (note is None)
        assert (note or "") in captured.err


@pytest.mark.parametrize(("complete", "said"), [(True, "could not be"), (False, "not yet")])
def test_points_that_an_interrupted_sweep_left_coarse_are_not_said_to_have_failed(complete: bool, said: str) -> None:
    mesh = {"steps": [50, 100], "largest_error": 0.997, "coarse": 1}
    (line,) = _mesh_lines(mesh, True, complete)
    assert line.endswith(f"the same gaits go as far within 100 %; 1 point {said} refined to 0.1 %")


@pytest.mark.parametrize("limit", ["", "joint_limit_deg = 60\n"])
@pytest.mark.parametrize(("angle", "warned"), [(0.5236, False), (30.0, True)])
def test_joints_beyond_half_a_turn_are_asked_for_their_unit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], angle: float, warned: bool, limit: str
) -> None:
    rows = f"angles = [[{angle}, 0.0], [0.0, {angle}], [-{angle}, 0.0], [0.0, -{angle}]]"
    gait = f'[gait]\nfamily = "table"\n{rows}\n[task]\nsteps = 4\n'
    path = written(tmp_path, BODY + limit + MEDIUM + gait)
    assert main(["simulate", path, "--no-figures", "--out", str(tmp_path / "o")]) == 0
    out = capsys.readouterr().out
    assert ("joint_1 reaches 1718.9 degrees, more than half a turn. Angles of gaits are in radians" in out) == warned
    assert ("half a turn" in out) == warned
    assert ("its limit is 60" in out) == (warned and bool(limit))


def test_steps_that_are_too_coarse_for_a_gait_are_warned_of_with_what_helps(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = written(tmp_path, BODY + MEDIUM + "[gait]\na = 3.0\n")
    few, first = ["--no-figures", "--set", "task.steps=4"], str(tmp_path / "first")
    assert main(["simulate", asked, "--out", first, *few]) == 0
    coarse = "warning           4 steps are too coarse for this gait: what it does is off by more than 5 %: "
    assert f"{coarse}--set task.steps=16\n" in capsys.readouterr().out
    assert main(["simulate", asked, "--no-figures", "--out", str(tmp_path / "third")]) == 0
    assert "too coarse" not in capsys.readouterr().out
    table = f'[gait]\nfamily = "table"\npath = "{first}/joint_table.csv"\n'
    played = written(tmp_path, BODY + MEDIUM + table)
    assert main(["simulate", played, "--no-figures", "--out", str(tmp_path / "second")]) == 0
    assert f"{coarse}give a joint table of 16 rows a cycle\n" in capsys.readouterr().out  # no key makes them more


@pytest.mark.parametrize(("solved", "complete", "told"), [(0, False, 0), (2, False, 1), (2, True, 2)])
def test_a_sweep_that_was_stopped_speaks_only_of_what_it_has(solved: int, complete: bool, told: int) -> None:
    summary = {
        "problem": "p", "folder": "f", "solved": solved, "failed": 0, "not_reached": 3 * (not complete), "failures": [],
        "kept_from_an_earlier_run": 0, "displacement": [0.2, 0.3] if solved else None, "limits": [], "mesh": None,
        "idle_for_minimum_between_1_and_2": None, "complete": complete,
    }  # fmt: skip
    lines = _lines(summary, 4, refined=False)
    assert sum("either end began" in line or "cost of transport" in line for line in lines) == told
