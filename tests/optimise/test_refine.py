"""Refining: limits hold on the finest mesh, and what fails or is stopped there does not take the place of what held."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from serpenoid.optimise import refine as refining
from serpenoid.optimise.interrupt import StopFlag
from serpenoid.optimise.multistart import MultiStart
from serpenoid.optimise.program.limits import TOLERANCE
from serpenoid.optimise.refine import refine, refine_best
from serpenoid.optimise.solution import Solution
from serpenoid.optimise.solve import solve
from serpenoid.optimise.solver import GaitSolver
from serpenoid.problem import Problem
from serpenoid.status import Status
from specimens import problem

HELD_BY_LIMITS = (
    "reference", "body.vertices=5", "body.joint_limit_deg=70", "medium.anisotropy_ratio=0.3", "task.c=0.5",
)  # fmt: skip


def held_by_limits(steps: int) -> Problem:
    """Three joints whose optimum is a circle: its phase is free, and its peaks move between rows that carry limits."""
    return problem(*HELD_BY_LIMITS, f"task.steps={steps}")


@cache
def coarse() -> MultiStart:
    return solve(held_by_limits(30), starts=1)


def test_limits_hold_on_the_finest_mesh() -> None:
    found = refine_best(coarse())
    best = found.solution
    assert best.status is Status.SOLVED
    assert found.failed is None
    assert best.mesh.steps == 240
    assert best.mesh.within(refining.REFINED)
    assert GaitSolver(best.problem).excess(best.table).max() <= TOLERANCE
    assert best.cost == pytest.approx(-0.2626, abs=1e-4)
    assert found.seconds > best.seconds > 0  # of all meshes


def test_rows_that_are_exchanged_come_to_an_end_on_a_fine_mesh() -> None:
    """Before, sixteen exchanges ended with a limit that was exceeded."""
    found = solve(held_by_limits(240), starts=1)
    assert found.best.status is Status.SOLVED
    assert found.best.cost == pytest.approx(-0.2626, abs=1e-4)


def test_a_finer_mesh_that_fails_leaves_the_finest_that_held(monkeypatch: pytest.MonkeyPatch) -> None:
    solved, begun = refining._finer, list[int]()

    def failing(*given: object) -> Solution:
        finer = solved(*given)  # type: ignore[arg-type]
        return finer if finer.mesh.steps < 120 else replace(finer, status=Status.NOT_CONVERGED, polishing_gain=None)

    monkeypatch.setattr(refining, "_finer", failing)
    found = refine_best(coarse(), progress=lambda last: begun.append(2 * last.mesh.steps))
    assert (found.solution.status, found.solution.mesh.steps) == (Status.SOLVED, 60)
    assert found.failed is not None
    assert (found.failed.status, found.failed.mesh.steps) == (Status.NOT_CONVERGED, 120)
    assert begun == [60, 120]  # it is not begun anew
    assert not found.stopped


def test_what_was_refused_for_its_mesh_is_kept_where_no_finer_one_converges(monkeypatch: pytest.MonkeyPatch) -> None:
    refused = replace(coarse().best, status=Status.MESH_TOO_COARSE)
    found = replace(coarse(), solutions=(refused,), optima=())
    astray = replace(refused, status=Status.NOT_CONVERGED)
    monkeypatch.setattr(refining, "_finer", lambda *_: astray)
    refined = refine_best(found)
    assert (refined.solution, refined.failed) == (refused, astray)


def test_a_mesh_that_is_stopped_leaves_the_last_that_held() -> None:
    flag, steps = StopFlag(), list[int]()

    def stop(_objective: float) -> None:
        flag.stopped = steps[-1] == 120

    found = refine(coarse().best, flag=flag, progress=lambda last: steps.append(2 * last.mesh.steps), watch=stop)
    assert found.stopped
    assert (found.solution.status, found.solution.mesh.steps) == (Status.SOLVED, 60)
    assert found.failed is None


def test_what_was_refused_for_its_mesh_is_what_is_left_where_the_first_finer_one_is_stopped() -> None:
    flag = StopFlag()
    refused = replace(coarse().best, status=Status.MESH_TOO_COARSE)
    found = refine(refused, flag=flag, watch=lambda _: setattr(flag, "stopped", True))
    assert found.stopped
    assert found.solution is refused


def test_what_has_not_converged_is_not_refined() -> None:
    """Minutes went into finer meshes of a gait that had gone astray."""
    astray = replace(coarse().best, status=Status.NOT_CONVERGED)
    assert refine(astray, progress=lambda _: pytest.fail("it is")).solution is astray


def test_how_many_meshes_are_foreseen_follows_from_the_error() -> None:
    mesh = coarse().best.mesh
    assert mesh.meshes(refining.REFINED, 6) == [60, 120, 240]  # 2 % of 30 steps, a quarter of it with each doubling
    assert mesh.meshes(refining.REFINED, 2) == [60, 120]
