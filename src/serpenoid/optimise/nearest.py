"""Where no start meets all demands: the gait that misses them least, in the sum of squares.

IPOPT's own last point spreads what is missed over the equations of motion, too, so that its gait, played, misses more.
Here motion, limits and obstacles hold, and what the demands and a prescribed heading miss is the objective; where that
comes down to nothing, they are asked for once more from there. A heading that is fixed far from where a search begins
tempts it to let a pose slip to another root of its step: the gait turns otherwise than the NLP has it. As an objective
it does not. The problem's own gait may miss less than all that: a body that stands still, beside obstacles.
"""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np

from serpenoid.objectives import Criteria
from serpenoid.optimise.asked import Customise
from serpenoid.optimise.certify import missed
from serpenoid.optimise.interrupt import StopFlag
from serpenoid.optimise.ipopt import Residuals
from serpenoid.optimise.multistart import MISSED, MultiStart, Optimum, solve_one
from serpenoid.optimise.solution import Solution
from serpenoid.optimise.solver import GaitSolver, Run
from serpenoid.problem import Problem
from serpenoid.status import Status


def with_nearest(
    solver: GaitSolver, found: MultiStart, customise: Customise | None = None, flag: StopFlag | None = None
) -> MultiStart:
    """The same; where no start met the demands, the best is the gait that misses them least, or one that meets them."""
    if type(solver) is not GaitSolver or flag or not _missing(solver, found.best):
        return found
    nearer = _nearer(solver, found, customise, flag) if _asks(solver) else found
    return nearer if nearer.optima else _or_own(solver, nearer)


def _asks(solver: GaitSolver) -> bool:
    """Whether there is something beside motion, limits and obstacles that a gait may miss."""
    return bool(solver.asked.criteria.added) or solver.heading_target() is not None


def _missing(solver: GaitSolver, best: Solution) -> bool:
    """Whether IPOPT ended without what is asked: beside what cannot be met it may not converge, or lose the motion."""
    astray = best.status in (Status.NOT_CONVERGED, Status.RESIMULATION_DISAGREES)
    return best.status is Status.INFEASIBLE or (astray and best.missed >= MISSED and _asks(solver))


def _nearer(solver: GaitSolver, found: MultiStart, customise: Customise | None, flag: StopFlag | None) -> MultiStart:
    """From where the best ended, and from the problem's own gait: the nearest there is, and the demands once more."""
    best, c, turn = found.best, solver.problem.task.c, solver.heading_target()
    search = GaitSolver(_heading_freely(solver.problem), softened(customise, turn), best.gait)
    begin = np.clip(best.q, *solver.gait_bounds()), solver.own_start()
    answers = [answer for q in begin if (answer := search.solve(q, 0.0, Run(flag=flag))).outcome.status.ok]
    if not answers:
        return found
    answers.sort(key=lambda answer: answer.outcome.objective)
    for answer in answers:
        if answer.outcome.objective < MISSED**2:
            again, _ = solve_one(solver, answer.q, c, Run(flag=flag), polish=True)
            if again.status.ok:
                return _with(found, best, again, (Optimum(again, 1),))
    shown = _of(solver, best, answers[0].q)
    status = Status.NOT_CONVERGED if shown.missed < MISSED else Status.INFEASIBLE
    return _with(found, best, replace(shown, status=status), ())


def _heading_freely(problem: Problem) -> Problem:
    """The same without a prescribed heading."""
    task = problem.task
    free = task.constraints.model_copy(update={"straight": False, "heading_change_rad": None})
    return problem.model_copy(update={"task": task.model_copy(update={"constraints": free})})


def _or_own(solver: GaitSolver, found: MultiStart) -> MultiStart:
    """With the problem's own gait in the place of the best, where it misses less; that meets all: not converged."""
    best, own = found.best, solver.own_start()
    gait = _of(solver, best, own)
    if not gait.trajectory.status.ok or gait.missed >= best.missed:
        return found
    status = Status.NOT_CONVERGED if gait.missed < MISSED else best.status
    return _with(found, best, replace(gait, status=status), ())


def softened(customise: Customise | None, turn: float | None = None) -> Customise:
    """What is asked for, a heading change `turn` [rad] too, becomes an objective: the sum of the squares of what it
    misses."""

    def soften(of: Criteria) -> None:
        if customise is not None:
            customise(of)
        of.minimise(ca.SX(0))
        for expression, lower, upper in of.added:
            of.also_minimise(ca.sumsqr(ca.fmax(lower - expression, 0)) + ca.sumsqr(ca.fmax(expression - upper, 0)))
        of.added.clear()
        if turn is not None:
            of.also_minimise((of.heading_change - turn) ** 2)

    return soften


def _of(solver: GaitSolver, failed: Solution, q: np.ndarray) -> Solution:
    """The failed solution with another gait and its motion; what a certificate was asked of the first is not of it."""
    table = solver.table(q)
    meshes, c = solver.on_meshes(q), solver.problem.task.c
    (motion, *_), (mesh, *_) = meshes, solver.mesh_studies(q, meshes)
    return replace(
        failed, gait=solver.family.gait(q), q=q, table=table, trajectory=motion, mesh=mesh,
        cost=solver.value(q, table, motion, c), missed=missed(solver, q, c), polishing_gain=None,
        residuals=Residuals(np.nan, np.nan, np.nan), resimulation_error=np.nan,
    )  # fmt: skip


def _with(found: MultiStart, old: Solution, new: Solution, optima: tuple[Optimum, ...]) -> MultiStart:
    return replace(found, solutions=tuple(new if s is old else s for s in found.solutions), optima=optima)
