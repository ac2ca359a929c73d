"""An optimum solved again with twice the steps, and again, until its displacement is the gait's and not the mesh's.

Each mesh begins with the gait of the one before. Where a limit holds that, all rows carry limits from the first: with
few the gait's phase moves until its peaks lie between them, on a fine mesh for more exchanges than there are. A finer
mesh that fails, or is stopped, does not take the place of one that converged.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from serpenoid.files.writing import CHAIN
from serpenoid.optimise.chain_store import ChainStore
from serpenoid.optimise.interrupt import StopFlag, catch_interrupt
from serpenoid.optimise.multistart import MultiStart, solve_one
from serpenoid.optimise.robust import solver_of
from serpenoid.optimise.solution import Solution
from serpenoid.optimise.solver import Run
from serpenoid.problem import Problem
from serpenoid.status import Status

REFINED = 1e-3  # of the displacement: as fine as a robot can be measured
DOUBLINGS = 6
MOST_REFINED = 3  # distinct optima better than the best certified one that are tried: each may cost six doublings
ASTRAY = (Status.STOPPED, Status.NOT_CONVERGED, Status.INFEASIBLE, Status.NOT_A_NUMBER)  # nothing begins well there
Progress = Callable[[Solution], None]
Kept = Callable[[int], ChainStore]  # steps -> where the answer with so many is kept


def kept_in(folder: str | Path, name: str) -> Kept:
    """Where answers on finer meshes are kept; name: of the answer that is refined, unique in the folder."""
    return lambda steps: ChainStore(Path(folder) / CHAIN, f"{name}-refined-{steps}")


@dataclass(frozen=True)
class Refined:
    """What refining came to.

    solution: of the finest mesh that converged; failed: of a finer one that did not; seconds: in IPOPT, on all finer
    meshes; stopped: by the user, before its end.
    """

    solution: Solution
    failed: Solution | None = None
    seconds: float = field(default=0.0, compare=False)
    stopped: bool = False


def refine(
    solution: Solution,
    flag: StopFlag | None = None,
    progress: Progress | None = None,
    watch: Callable[[float], None] | None = None,
    kept_at: Kept | None = None,
    polish: bool = True,
) -> Refined:
    """The same problem solved with twice the steps, from this solution's motion, and again until its mesh is fine.

    Fine: the displacement's error is at most REFINED of its limit. A gait that no mesh confirms stays refused.
    `progress(solution)` is called before each mesh with what is solved again, `watch(objective)` at each iteration.
    What is kept at `kept_at(steps)` is not solved again.
    """
    last, kept, seconds = solution, solution, 0.0
    for _ in range(DOUBLINGS):
        if flag or not last.trajectory.status.ok or last.status in ASTRAY or last.mesh.within(REFINED):
            break
        if progress is not None:
            progress(last)
        finer = _finer(last, flag, watch, kept_at, polish)
        seconds += finer.seconds
        if flag and (finer.status is Status.STOPPED or (polish and finer.polishing_gain is None)):  # not to its end
            break
        last = finer
        if _rank(last) >= _rank(kept):
            kept = last
    return Refined(kept, None if kept is last else last, seconds, bool(flag))


def refine_best(
    found: MultiStart, progress: Progress | None = None, watch: Callable[[float], None] | None = None
) -> Refined:
    """The best of all starts refined: of optima that their mesh alone spoils, too, a few, best first.

    A coarse mesh may promise more than there is, so the next is tried while it promises more than the best refined.
    Ctrl-C ends it and returns what there is.
    """
    coarse = [optimum.solution for optimum in found.better_but_coarse[:MOST_REFINED]]
    tried: list[Refined] = []
    with catch_interrupt() as flag:
        for solution in [*coarse, *(optimum.solution for optimum in found.optima[:1])] or [found.best]:
            if flag or any(_holds(r) and r.solution.objective <= solution.objective for r in tried):
                break
            tried.append(refine(solution, flag=flag, progress=progress, watch=watch))
        stopped = bool(flag)
    held = [r for r in tried if _holds(r)]
    if stopped and not held and found.optima:
        held = [Refined(found.best)]
    best = min(held, key=lambda r: r.solution.objective) if held else (tried or [Refined(found.best)])[0]
    return replace(best, seconds=sum(r.seconds for r in tried), stopped=stopped)


def _rank(solution: Solution) -> int:
    """Certified, an optimum that its mesh alone spoils, or none."""
    return 2 * solution.status.ok + (solution.status is Status.MESH_TOO_COARSE)


def _holds(refined: Refined) -> bool:
    return refined.solution.status.ok


def _finer(
    solution: Solution,
    flag: StopFlag | None,
    watch: Callable[[float], None] | None,
    kept_at: Kept | None,
    polish: bool,
) -> Solution:
    """The problem with twice the steps, solved from this solution's gait, at its c."""
    problem, family = with_steps(solution.problem, 2 * solution.mesh.steps), solution.problem.family_of(solution.gait)
    gait = family.refined(2).gait(family.on_finer_rows(solution.q, 2))
    solver = solver_of(problem, gait=gait)
    start = np.clip(solver.family.start(), *solver.gait_bounds())
    carried = solver.about(start, good=True)
    store = None if kept_at is None else kept_at(problem.task.steps)
    return solve_one(solver, start, solution.c, Run(None, carried, flag, watch), polish, store)[0]


def with_steps(problem: Problem, steps: int) -> Problem:
    """The same problem on another time mesh."""
    return problem.model_copy(update={"task": problem.task.model_copy(update={"steps": steps})})
