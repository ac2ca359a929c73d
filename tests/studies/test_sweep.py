"""The family over c: continuation is the cold answer, a killed sweep resumes, another problem's points are not used."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from serpenoid.body import Floats
from serpenoid.cli.main import main
from serpenoid.errors import InputError
from serpenoid.optimise.chain_store import ChainStore
from serpenoid.optimise.ipopt import Point
from serpenoid.optimise.refine import REFINED
from serpenoid.optimise.solve import solve
from serpenoid.optimise.solver import Answer, GaitSolver, Run
from serpenoid.performance import pareto_front
from serpenoid.studies.beside import Beside, beside_of
from serpenoid.studies.sweep import Sweep, sweep
from serpenoid.studies.sweep_results import write_sweep
from specimens import problem

PROBLEMS = Path(__file__).parents[2] / "problems"
VALUES = (0.0, 0.5, 1.0, 2.0)
SAME_COST = 1e-7


def costs(result: Sweep) -> np.ndarray:
    return np.array([s.cost for s in result.solved])


@pytest.fixture(scope="module")
def family() -> Sweep:
    return sweep(problem("reference-optimum"), VALUES, starts=3, seed=0)


def test_continuation_finds_what_cold_multi_starts_find(family: Sweep) -> None:
    cold = [solve(problem("reference-optimum", f"task.c={c}"), starts=6, seed=3).best.cost for c in VALUES]
    np.testing.assert_allclose(costs(family), cold, atol=SAME_COST)
    assert all(s.status.ok and s.residuals.largest <= 1e-8 and s.resimulation_error <= 1e-8 for s in family.solved)


def test_along_the_family_distance_and_dissipation_fall_and_every_point_is_on_the_front(family: Sweep) -> None:
    # an exchange argument: the best at each of two values of c cannot beat each other at both
    assert (np.diff(family.displacement) < 1e-9).all()
    assert (np.diff(family.dissipation) < 1e-9).all()
    assert pareto_front(family.displacement, family.dissipation).all()
    # cost is concave in c with slope dissipation (envelope theorem)
    slope = np.diff(costs(family)) / np.diff(VALUES)
    assert (slope <= family.dissipation[:-1] + 1e-9).all()
    assert (slope >= family.dissipation[1:] - 1e-9).all()


@pytest.mark.slow
def test_more_starts_lose_nothing_amid_the_family() -> None:
    """What is best at an end need not lead to what is best at another c: every optimum of an end is followed."""
    asked = problem("reference-optimum", "body.vertices=14", "medium.anisotropy_ratio=0.5", "body.joint_limit_deg=50.0")
    few, many = (costs(sweep(asked, np.linspace(0, 2.5, 6), n, seed=0, polish=False)) for n in (4, 8))
    assert (many <= few + SAME_COST).all()  # followed from the best alone, 8 starts lost 1.3e-4 of 0.074 at c = 1


def test_a_killed_sweep_goes_on_where_it_stopped(tmp_path: Path, family: Sweep) -> None:
    asked = problem("reference-optimum")
    sweep(asked, VALUES[:2], starts=3, seed=0, folder=tmp_path)
    before = {p: p.stat().st_mtime_ns for p in (tmp_path / "chain").glob("up-*.npz")}
    assert len(before) == 2
    resumed = sweep(asked, VALUES, starts=3, seed=0, folder=tmp_path)
    assert {p: p.stat().st_mtime_ns for p in before} == before  # solved once
    assert (family.kept, resumed.kept) == (0, 2)
    np.testing.assert_allclose(costs(resumed), costs(family), atol=SAME_COST)


def test_points_stored_for_another_problem_are_solved_anew(tmp_path: Path) -> None:
    sweep(problem("reference-optimum"), VALUES[:2], starts=1, seed=0, folder=tmp_path)
    changed = problem("reference-optimum", "medium.anisotropy_ratio=0.1")
    result = sweep(changed, VALUES[:2], starts=1, seed=0, folder=tmp_path)
    assert len(result.solved) == 2
    np.testing.assert_allclose(costs(result), costs(sweep(changed, VALUES[:2], starts=1, seed=0)), atol=SAME_COST)


def test_a_point_stored_for_a_longer_table_is_solved_anew(tmp_path: Path) -> None:
    sweep(problem("reference-optimum", "task.steps=20"), [0.5], starts=1, folder=tmp_path, polish=False)
    shorter = GaitSolver(problem("reference-optimum", "task.steps=5"))
    assert ChainStore(tmp_path / "chain", "up").load(0.5, shorter) is None


def test_a_stored_point_that_was_cut_short_is_solved_anew(tmp_path: Path) -> None:
    solver, store = GaitSolver(problem("reference-optimum")), ChainStore(tmp_path, "up")
    assert store.load(0.5, solver) is None
    for rubbish in (b"PK\x03\x04 half a file", b""):
        (tmp_path / "up-0.5.npz").write_bytes(rubbish)
        assert store.load(0.5, solver) is None


def test_a_point_that_ctrl_c_comes_amid_is_not_reached_and_none_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    solve_point, solved = GaitSolver.solve, []

    def interrupted(self: GaitSolver, start: Floats | Point, c: float, run: Run) -> Answer:
        solved.append(1)
        assert run.flag is not None
        run.flag.stopped = len(solved) > 2  # amid the third: IPOPT ends at its next iteration
        return solve_point(self, start, c, run)

    monkeypatch.setattr(GaitSolver, "solve", interrupted)
    result = sweep(problem("reference-optimum"), VALUES, starts=1, seed=0)
    assert not result.complete
    assert [(p.reached, p.solution is not None) for p in result.points] == [(True, True)] * 2 + [(False, False)] * 2


def test_a_refined_point_is_the_optimum_of_a_finer_mesh_and_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At another c than the file's; the second time nothing is solved."""
    asked = problem("reference-optimum", "task.steps=20")
    done: list[int] = []
    found = sweep(asked, [0.5], 1, 0, tmp_path, False, lambda n, _: done.append(n), refined=True)
    best = found.solved[0]
    direct = solve(problem("reference-optimum", f"task.steps={best.mesh.steps}", "task.c=0.5"), starts=1).best
    assert (best.c, best.mesh.steps > 20, best.mesh.within(REFINED)) == (0.5, True, True)
    assert best.cost == pytest.approx(direct.cost, abs=SAME_COST)
    assert done[-1] == 3  # up, down, refined
    assert write_sweep(tmp_path, found, figures=False)["mesh"]["coarse"] == 0
    monkeypatch.setattr(GaitSolver, "solve", lambda *_, **__: pytest.fail("it is kept"))
    again = sweep(asked, [0.5], 1, 0, tmp_path, False, refined=True)
    assert again.solved[0].cost == pytest.approx(best.cost, abs=1e-12)


def test_a_value_of_c_that_cannot_be_solved_is_recorded_and_the_others_go_on() -> None:
    impossible = problem(
        "reference-optimum", "task.constraints.heading_change_rad=3.0", "task.bounds.a=[0.0, 0.5]", "task.steps=12"
    )
    result = sweep(impossible, (0.0, 1.0), starts=1, seed=0)
    assert result.complete
    assert [p.solution for p in result.points] == [None, None]
    assert all(p.message for p in result.points)


def test_a_gait_of_the_family_goes_as_far_as_the_best_and_one_that_is_scaled_does_not(family: Sweep) -> None:
    amid = sweep(problem("reference-optimum"), [0.7], starts=3, seed=0).solved[0].trajectory
    best = Beside("optimum", amid.displacement, amid.dissipation).against(family)
    # four values of c: `between` is good to a few thousandths here
    assert best["most_displacement"] == pytest.approx(amid.displacement, rel=4e-3)
    assert best["least_dissipation"] == pytest.approx(amid.dissipation, rel=2e-2)
    lazy = Beside("scaled", 0.9 * amid.displacement, amid.dissipation).against(family)
    assert lazy["most_displacement"] == best["most_displacement"]
    assert lazy["least_dissipation"] < amid.dissipation
    beyond = Beside("beyond", 0.0, 100.0).against(family)
    assert beyond["most_displacement"] is beyond["least_dissipation"] is None


def test_a_sweep_says_how_near_a_files_own_gait_is_to_its_best(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    file, out = str(PROBLEMS / "reference-optimum.toml"), str(tmp_path / "out")
    words = ["sweep", file, "--set", "task.steps=24", "--starts", "2", "--no-polish", "--no-figures", "--out", out]
    assert main([*words, "--c", "0,0.5,1,4", "--beside", file]) == 0
    assert re.search(
        r"reference-optimum goes 0\.\d+ for .*; the best of these go 0\.\d+ for as much: it goes \d+ % of that; they "
        r"go as far for 0\.",
        capsys.readouterr().out,
    )
    assert main(["show", out]) == 0
    assert "\nreference-optimum goes 0." in capsys.readouterr().out
    pytest.importorskip("distributed", reason="needs the extra `cluster`")
    assert main([*words, "--c", "0,0.5,1,4", "--beside", file, "--cluster", "local:1"]) == 0
    assert "reference-optimum goes 0." in capsys.readouterr().out
    assert main([*words, "--force", "--c", "0,0.1", "--beside", file]) == 0
    assert "outside of what these gaits spend and go; widen --c" in capsys.readouterr().out
    assert main(["sweep", file, file, "--beside", file]) == 2


def test_a_gait_of_another_body_or_in_another_medium_is_not_compared() -> None:
    asked, file = problem("reference-optimum"), PROBLEMS / "reference-optimum.toml"
    with pytest.raises(InputError, match="has another body, medium or effects than"):
        beside_of(asked, PROBLEMS / "purcell.toml")
    with pytest.raises(InputError, match="has another body, medium or effects than"):
        beside_of(asked, file, ["medium.anisotropy_ratio=0.9"])
    assert beside_of(asked, file, ["gait.xi=0.7", "task.bounds.xi=[1, 2]"]) == beside_of(asked, file)
