"""The optimiser's front door: many random starts, one start, or the paper's set of improved random gaits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from serpenoid.body import Floats
from serpenoid.gaits import Gait
from serpenoid.optimise.asked import Customise
from serpenoid.optimise.interrupt import StopFlag, catch_interrupt
from serpenoid.optimise.multistart import MultiStart, solve_many, solve_one
from serpenoid.optimise.nearest import with_nearest
from serpenoid.optimise.robust import solver_of
from serpenoid.optimise.solution import Solution
from serpenoid.optimise.solver import GaitSolver, Run
from serpenoid.optimise.starts import inside, random_gaits, within
from serpenoid.optimise.weights import check_weights
from serpenoid.problem import Problem
from serpenoid.shown import Shown
from serpenoid.simulation.callers import folder_of, gait_of, problem_of, whole
from serpenoid.trajectory import Trajectory

Progress = Callable[[int, Solution | None], None]


def solve(
    problem: Problem | str | Path,
    starts: int = 12,
    seed: int = 0,
    customise: Customise | None = None,
    progress: Progress | None = None,
    folder: str | Path | None = None,
    watch: Callable[[float], None] | None = None,
) -> MultiStart:
    """Optimise the gait of a problem, or of its file, from `starts` random gaits (its own gait is the first start).

    `customise(criteria)` may add to the objective and the constraints. `progress(done, best)` is called after each
    start, `watch(objective)` after each iteration of one. Ctrl-C ends the search and returns what there is. With
    `folder` each solved start is kept there, and taken from there the next time (with `customise` give each choice a
    folder of its own).
    """
    problem, starts, seed = problem_of(problem), whole("starts", starts, 1), whole("seed", seed, 0)
    folder = folder_of(folder)
    _check_weights(problem, customise)
    solver = solver_of(problem, customise)
    gaits = starts_of(solver, starts, seed)
    solver.prepare(gaits[0])
    with catch_interrupt() as flag:
        found = solve_many(solver, gaits, problem.task.c, flag, progress, folder, watch)
        return with_nearest(solver, found, customise, flag)


def _check_weights(problem: Problem, customise: Customise | None = None) -> None:
    """What a user's own terms weigh is not known."""
    if customise is None:
        check_weights(problem, [problem.task.c])


def starts_of(solver: GaitSolver, starts: int, seed: int) -> Floats:
    """The problem's own gait, if it moves, then random ones, shape (starts, n)."""
    gaits = random_gaits(solver, starts, seed)
    if solver.family.moves(own := solver.own_start()) and (own_inside := inside(solver, own)) is not None:
        gaits[0] = own_inside
    return gaits


def solve_from(problem: Problem | str | Path, gait: Gait, customise: Customise | None = None) -> Solution:
    """Optimise from one gait, in its family; the answer is certified with polishing."""
    problem, gait = problem_of(problem), gait_of(gait)
    _check_weights(problem, customise)
    solver = solver_of(problem, customise, gait)
    start = np.clip(solver.family.start(), *solver.gait_bounds())
    solver.prepare(start)
    with catch_interrupt() as flag:
        return solve_one(solver, start, problem.task.c, Run(flag=flag), polish=True)[0]


@dataclass(frozen=True, repr=False, eq=False)
class Improved(Shown):
    """A random gait (q, joint table, motion) and the best gait within a fraction of its own parameters."""

    q: Floats
    table: Floats
    trajectory: Trajectory
    solution: Solution

    def summary(self) -> str:
        """How far the random gait goes, and what became of it."""
        return f"{self.trajectory.displacement:.6f} body lengths; {self.solution.summary()}"


def improve(
    problem: Problem | str | Path,
    count: int = 12,
    fraction: float = 0.3,
    seed: int = 0,
    progress: Callable[[int], None] | None = None,
) -> list[Improved]:
    """The paper's set: `count` random gaits, each improved within +-`fraction` of its own parameters."""
    problem, seed = problem_of(problem), whole("seed", seed, 0)
    count = whole("count", count, 1, "To improve a gait of your own: solve_from(problem, gait).")
    _check_weights(problem)
    solver = solver_of(problem)
    gaits = random_gaits(solver, count, seed)
    solver.prepare(gaits[0])
    result: list[Improved] = []
    with catch_interrupt() as flag:
        for q in gaits:
            if flag:
                break
            result.append(_improve_one(solver, q, fraction, flag))
            if progress is not None:
                progress(len(result))
    return result


def _improve_one(solver: GaitSolver, q: Floats, fraction: float, flag: StopFlag) -> Improved:
    bounds = within(solver, q, fraction)
    solution, _ = solve_one(solver, q, solver.problem.task.c, Run(bounds, flag=flag), polish=True)
    table = solver.table(q)
    return Improved(q, table, solver.simulate(q), solution)
