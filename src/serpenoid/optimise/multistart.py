"""Many starts, one summary: the certified local optima, how often each was found, and how many starts failed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from serpenoid.body import Floats
from serpenoid.optimise.certify import certify, missed
from serpenoid.optimise.chain_store import ChainStore, store_of
from serpenoid.optimise.interrupt import StopFlag
from serpenoid.optimise.ipopt import Point
from serpenoid.optimise.motions import GaitBounds
from serpenoid.optimise.solution import Solution
from serpenoid.optimise.solver import AS_ASKED, Answer, GaitSolver, Run
from serpenoid.shown import Shown
from serpenoid.status import Status
from serpenoid.wording import FOUND_ONCE, counted

SAME_COST = 1e-6  # optima whose objectives differ by less are one: mirror images and half turns of theta are equal
MISSED = 1e-6  # of a constraint: far above the optimiser's tolerance
Progress = Callable[[int, "Solution | None"], None]


@dataclass(frozen=True)
class Optimum:
    """A distinct local optimum: its best solution and how many starts reached it."""

    solution: Solution
    count: int


@dataclass(frozen=True, repr=False, eq=False)
class MultiStart(Shown):
    """All solutions in the order of their starts; `optima` distinct and certified, best first; kept: how many of the
    solutions an earlier run had found."""

    solutions: tuple[Solution, ...]
    optima: tuple[Optimum, ...]
    kept: int = 0

    def summary(self) -> str:
        """How many starts, how many optima, and the best."""
        optima = "1 optimum" if len(self.optima) == 1 else f"{len(self.optima)} optima"
        once = f"; {FOUND_ONCE}" if self.optima and self.optima[0].count == 1 else ""
        return f"{counted(len(self.solutions), 'start')}, {optima}; best {self.best.summary()}{once}"

    @property
    def best(self) -> Solution:
        """The best certified optimum, else a failure: a stopped one first, then the best that its mesh alone spoils.

        Of others the one whose gait, simulated, misses what is asked least, and of equal ones the cheapest.
        """
        if self.optima:
            return self.optima[0].solution
        first = (Status.STOPPED, Status.MESH_TOO_COARSE)
        ranks = {status: rank for rank, status in enumerate(first)}

        def order(s: Solution) -> tuple[int, float, float]:
            cost = s.cost if np.isfinite(s.cost) else np.inf
            return ranks.get(s.status, len(first)), 0.0 if s.missed < MISSED else s.missed, cost

        return min(self.solutions, key=order)

    @property
    def coarse(self) -> tuple[Optimum, ...]:
        """Distinct optima that their mesh alone spoils, best first: what they gain may be the mesh's."""
        groups = _groups(self.solutions, Status.MESH_TOO_COARSE)
        return tuple(Optimum(self.solutions[group[0]], len(group)) for group in groups)

    @property
    def better_but_coarse(self) -> tuple[Optimum, ...]:
        """Those of them that promise more than every certified optimum."""
        if not self.optima:
            return self.coarse
        least = self.optima[0].solution.objective - SAME_COST
        return tuple(optimum for optimum in self.coarse if optimum.solution.objective < least)

    @property
    def failures(self) -> tuple[Solution, ...]:
        """Starts that did not end in a certified optimum, though nobody stopped them."""
        return tuple(s for s in self.solutions if not s.status.ok and s.status is not Status.STOPPED)


def solve_one(
    solver: GaitSolver,
    start: Floats | Point,
    c: float,
    run: Run = AS_ASKED,
    polish: bool = False,
    store: ChainStore | None = None,
) -> tuple[Solution, Answer]:
    """Optimise from one start, or take what is stored, and certify the answer."""
    answer = store.load(c, solver) if store is not None else None
    if answer is None:
        answer = solver.solve(start, c, run)
        if store is not None and answer.outcome.status.ok:
            store.save(c, answer)
    return as_solution(solver, answer, c, polish, run.gait_bounds, run.flag), answer


def as_solution(
    solver: GaitSolver,
    answer: Answer,
    c: float,
    polish: bool,
    gait_bounds: GaitBounds | None = None,
    flag: StopFlag | None = None,
) -> Solution:
    """Certify an answer and write it as a Solution."""
    check = certify(solver, answer, c, polish, gait_bounds, flag)
    outcome = answer.outcome
    meshes = solver.on_meshes(answer.q)
    studies = solver.mesh_studies(answer.q, meshes)
    mesh = next((study for study in studies if not study.converged), studies[0])
    own, status = solver.self_clearance(check.table), check.status
    if status.ok and own is not None and own.proven < own.wanted:
        status = Status.TOUCHES_ITSELF
    coarse = status.ok and not mesh.converged
    return Solution(
        status=Status.MESH_TOO_COARSE if coarse else status,
        problem=solver.problem,
        c=c,
        gait=solver.family.gait(answer.q),
        names=solver.family.names,
        q=answer.q,
        table=check.table,
        trajectory=check.trajectory,
        cost=check.cost,
        objective=np.nan if status is Status.NOT_A_NUMBER else outcome.objective,  # IPOPT's is 0 there
        residuals=outcome.residuals,
        resimulation_error=check.resimulation_error,
        polishing_gain=check.polishing_gain,
        clearance=answer.clearance,
        fine_clearance=None if answer.clearance is None else solver.fine_clearance(answer.q, meshes[-1]),
        mesh=mesh,
        ipopt_status=outcome.ipopt_status,
        iterations=answer.iterations,
        seconds=answer.seconds,
        timing=outcome.timing,
        cases=solver.outcomes(answer.q, c),
        self_clearance=own,
        rest_is_as_good=check.rest_is_as_good,
        missed=0.0 if status.ok else missed(solver, answer.q, c),
    )


def solve_many(
    solver: GaitSolver,
    starts: Floats,
    c: float,
    flag: StopFlag | None = None,
    progress: Progress | None = None,
    folder: str | Path | None = None,
    watch: Callable[[float], None] | None = None,
) -> MultiStart:
    """Optimise from every start (S, n), kept in `folder` when solved; polish the best of each distinct optimum."""
    found: list[tuple[Solution, Answer]] = []
    for i, start in enumerate(starts):
        if flag:
            break
        found.append(solve_one(solver, start, c, Run(flag=flag, watch=watch), store=store_of(folder, start)))
        if progress is not None:
            progress(i + 1, best_of([s for s, _ in found]))
    return summarised(solver, found, c, flag)


def summarised(
    solver: GaitSolver, found: list[tuple[Solution, Answer]], c: float, flag: StopFlag | None = None
) -> MultiStart:
    """Answers in the order of their starts -> distinct optima, each polished unless the flag is raised."""
    solutions = [s for s, _ in found]
    groups = list(_groups(solutions))
    optima = []
    for group in groups:
        polished = solutions[group[0]] if flag else as_solution(solver, found[group[0]][1], c, polish=True, flag=flag)
        if polished.status.ok:
            optima.append(Optimum(polished, len(group)))
        for index in group:
            solutions[index] = replace(solutions[index], status=polished.status, polishing_gain=polished.polishing_gain)
    return MultiStart(tuple(solutions), tuple(optima), sum(answer.kept for _, answer in found))


def _groups(solutions: Sequence[Solution], status: Status = Status.SOLVED) -> Iterator[list[int]]:
    """Indices of starts that ended so, with the same objective, best first."""
    good = sorted((i for i, s in enumerate(solutions) if s.status is status), key=lambda i: solutions[i].objective)
    costs = np.array([solutions[i].objective for i in good])
    cuts = np.flatnonzero(np.diff(costs) > SAME_COST) + 1
    return (list(part) for part in np.split(np.array(good, int), cuts) if part.size)


def best_of(solutions: Iterable[Solution]) -> Solution | None:
    """The certified one of least objective, if there is one."""
    return min((s for s in solutions if s.status.ok), key=lambda s: s.objective, default=None)
