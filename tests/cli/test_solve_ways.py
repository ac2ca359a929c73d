"""`solve` in its several ways: options that contradict each other are refused, families that fail are told."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from serpenoid.cli.main import main
from serpenoid.optimise.multistart import MultiStart
from serpenoid.results import read_record
from serpenoid.status import Status

REFERENCE = Path(__file__).parents[2] / "problems" / "reference-optimum.toml"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--ladder", "--improve", "3"], "--ladder and --improve: are two ways"),
        (["--within", "0.2"], "--within: says how far --improve may go, got 0.2"),
        (["--ladder", "--refine"], "--refine: is not known with --ladder"),
        (["--improve", "3", "--refine"], "--refine: is not known with --improve"),
    ],
)
def test_options_that_would_do_nothing_together_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    assert main(["solve", str(REFERENCE), *words, "--out", str(tmp_path / "out")]) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_family_that_fails_on_the_ladder_is_listed_with_the_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from dataclasses import replace

    from serpenoid.optimise import ladder

    solve_from = ladder.solve_from

    def failing(problem, gait, customise):  # type: ignore[no-untyped-def]
        found = solve_from(problem, gait, customise)
        return replace(found, status=Status.NOT_CONVERGED) if gait.family == "fourier" else found

    monkeypatch.setattr(ladder, "solve_from", failing)
    words = ["--set", "body.vertices=5", "--starts", "1", "--ladder", "--no-figures"]
    assert main(["solve", str(REFERENCE), *words, "--c", "0.5", "--out", str(tmp_path / "out")]) == 1
    captured = capsys.readouterr()
    steps = json.loads((tmp_path / "out" / "ladder.json").read_text())["steps"]
    assert [step["status"] for step in steps][1] == "not_converged"
    assert len(steps) == 4
    assert "Fourier, serpenoid: not_converged: IPOPT did not converge" in captured.err
    assert "100%" in captured.err


def test_an_optimum_that_stands_still_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--c", "50", "--starts", "1", "--no-figures", "--set", "gait={family='fourier-joints',orders=[1]}"]
    assert main(["solve", str(REFERENCE), *words, "--set", "task.bounds={family='fourier-joints'}", "--out",
                 str(tmp_path / "out")]) == 0  # fmt: skip
    out = capsys.readouterr().out
    assert "note              a body that stands still does as well" in out
    assert "-0.000000" not in out
    assert "%" not in out  # of what?
    assert "efficiency" not in out


@pytest.mark.parametrize(("more", "said"), [([], True), (["--set", "body.joint_limit_deg=80"], False)])
def test_a_free_table_that_nothing_holds_is_told_what_would(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], more: list[str], said: bool
) -> None:
    file = tmp_path / "free.toml"
    file.write_text("[body]\nvertices=4\n[medium]\nanisotropy_ratio=0.1\n[gait]\nfamily='table'\n[task]\nsteps=5\n")
    words = ["solve", str(file), *more, "--starts", "1", "--no-figures", "--out", str(tmp_path / "out")]
    assert main(words) == 1  # five steps are too few
    assert ("give [body] joint_limit_deg" in capsys.readouterr().err) == said


def test_show_says_what_was_not_tried_and_gives_no_reason_that_it_does_not_know(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["solve", str(REFERENCE), "--set", "task.steps=8", "--starts", "1", "--out", str(tmp_path), "--no-figures"]
    assert main(words) == 1  # eight steps are too coarse
    assert main(["show", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert "polishing gain None" not in out
    assert out.count("polishing gain not tried") == 2
    assert out.rstrip().endswith("pictures          none")


def test_what_a_gait_makes_of_its_goals_is_in_the_record_and_shown(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    demands = 'task.demands=[{kind="travel",least=0.2},{kind="reach",target=[0.3,0.0],radius=0.5}]'
    asked = [str(REFERENCE), "--set", demands, "--set", "gait.a=6", "--no-figures", "--out"]
    for verb, folder in (("simulate", tmp_path / "one"), ("solve", tmp_path / "two")):
        assert main([verb, *asked, str(folder), *(["--starts", "1"] if verb == "solve" else [])]) == 0
        said = [line[18:] for line in capsys.readouterr().out.splitlines() if line.startswith("goal ")]
        assert len(said) == 2
        assert all("met" in words for words in said)
        assert read_record(folder)["goals"] == said
        (folder / "summary.txt").unlink()
        assert main(["show", str(folder)]) == 0
        shown = capsys.readouterr().out
        assert all(f"goal              {words}\n" in shown for words in said)


@pytest.mark.parametrize(("law", "name"), [("viscous", "T*E"), ("coulomb", "E  "), ("quadratic", "T^2*E")])
def test_the_dissipation_is_named_by_what_it_is_and_show_knows_dry_friction(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], law: str, name: str
) -> None:
    words = ["simulate", str(REFERENCE), "--set", f"medium.law={law}", "--set", "gait.a=4", "--no-figures", "--out"]
    assert main([*words, str(tmp_path)]) == 0
    assert f"dissipation {name}" in capsys.readouterr().out
    (tmp_path / "summary.txt").unlink()
    assert main(["show", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    assert f"dissipation {name}" in shown
    assert ("at each vertex, dry friction" in shown) == (law == "coulomb")


def test_a_sweep_of_failures_says_why_and_tells_no_displacement(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    coarse = ["sweep", str(REFERENCE), "--set", "task.steps=8", "--c", "0,1", "--starts", "1", "--out", str(tmp_path)]
    assert main(coarse) == 1
    out = capsys.readouterr().out
    assert "0 points solved, 2 failed" in out
    assert "failed at c = 0: down and up: the displacement" in out
    assert "the displacement depends on the number of steps" in out
    assert "(1 more: sweep.csv)" in out
    assert "displacement 0.0000" not in out
    record = read_record(tmp_path, "sweep.json")
    assert record["displacement"] is None
    assert [failure["c"] for failure in record["failures"]] == [0.0, 1.0]


def refining(folder: Path, *words: str) -> list[str]:
    """A command that solves with 30 steps and refines to 240."""
    sets = ("body.vertices=5", "body.joint_limit_deg=70", "medium.anisotropy_ratio=0.3", "task.c=0.5", "task.steps=30")
    asked = [word for value in sets for word in ("--set", value)]
    return ["solve", str(REFERENCE), *asked, "--starts", "1", "--refine", "--no-figures", "--out", str(folder), *words]


def test_refining_says_on_which_mesh_it_is_and_counts_its_time(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(refining(tmp_path / "out", "--log-file", str(tmp_path / "log"))) == 0
    said, log = capsys.readouterr(), (tmp_path / "log").read_text()
    assert "refined           -0.262" in said.out
    assert "for 1 start, " in said.out
    assert " s for finer meshes" in said.out
    assert "refining" in said.err
    for steps in (60, 120, 240):
        assert f" of 420 {steps} steps, {steps // 2} had cost" in log
    record = json.loads((tmp_path / "out" / "solution.json").read_text())["refinement"]
    assert record["seconds"] > 0
    assert (record["stopped"], record["failed"]) == (False, None)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_stop_while_refining_keeps_the_finest_mesh_that_converged(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    @contextmanager
    def bar(_args: object, title: str, _total: float) -> Iterator[object]:
        def advance(_done: float, text: str = "", **_: object) -> None:
            if title == "refining" and text.startswith("120 steps"):
                os.kill(os.getpid(), number)

        yield advance

    monkeypatch.setattr("serpenoid.cli.options.progress_bar", bar)
    assert main(refining(tmp_path)) == 130
    assert "stopped while refining; the finest mesh that converged, of 60 steps, is in" in capsys.readouterr().err
    record = json.loads((tmp_path / "solution.json").read_text())
    assert (record["status"], record["mesh"]["steps"][0]) == ("solved", 60)
    assert record["refinement"]["stopped"]


def test_a_stop_while_refining_does_not_take_the_place_of_a_finer_answer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from serpenoid.optimise import refine

    assert main(refining(tmp_path)) == 0
    held = refine.refine_best

    def stopped(found: MultiStart, *news: object) -> refine.Refined:
        return refine.Refined(held(found).solution if not news else found.best, stopped=True)

    monkeypatch.setattr(refine, "refine_best", stopped)
    assert main(refining(tmp_path)) == 130
    assert "keeps the answer of an earlier run, which is better" in capsys.readouterr().err
    assert json.loads((tmp_path / "solution.json").read_text())["mesh"]["steps"][0] == 240


@pytest.mark.parametrize("where", ["ellipse", "unpolished", "next"])
def test_ctrl_c_on_the_ladder_is_told_as_a_stop(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, where: str
) -> None:
    from dataclasses import replace

    from serpenoid.optimise import ladder

    solve = ladder.solve

    def first(problem, starts, seed):  # type: ignore[no-untyped-def]
        found = solve(problem, starts, seed)
        if where == "next":
            return found
        if where == "ellipse":
            return MultiStart((replace(found.best, status=Status.STOPPED),), ())
        optima = tuple(replace(o, solution=replace(o.solution, polishing_gain=None)) for o in found.optima)
        return replace(found, optima=optima)

    def then(_problem, _gait, _customise):  # type: ignore[no-untyped-def]
        assert where == "next"
        return replace(solve(REFERENCE, 1).best, status=Status.STOPPED)

    monkeypatch.setattr(ladder, "solve", first)
    monkeypatch.setattr(ladder, "solve_from", then)
    words = ["--set", "body.vertices=5", "--starts", "1", "--ladder", "--no-figures", "--c", "0.5"]
    assert main(["solve", str(REFERENCE), *words, "--out", str(tmp_path / "out")]) == 130
    assert "stopped after" in (said := capsys.readouterr().err)
    assert "The same command begins anew." in said
