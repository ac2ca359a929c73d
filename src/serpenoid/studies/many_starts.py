"""A multi-start on the one parallel loop: every start a task, the same answers to the last bit as one after another.

Solved starts are kept in the results folder by whoever asks, not by the workers: these need no common folder.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from serpenoid.body import Floats
from serpenoid.files.writing import write_csv
from serpenoid.optimise.chain_store import store_of
from serpenoid.optimise.interrupt import StopFlag
from serpenoid.optimise.multistart import MultiStart, Optimum, Progress, as_solution, best_of, summarised
from serpenoid.optimise.nearest import with_nearest
from serpenoid.optimise.robust import solver_of
from serpenoid.optimise.solution import Solution
from serpenoid.optimise.solve import starts_of
from serpenoid.optimise.solver import Answer, GaitSolver
from serpenoid.optimise.weights import check_weights
from serpenoid.parallel import Workers, results
from serpenoid.problem import Problem

HEADER = ("start", "status", "optimum", "displacement_body_lengths", "dissipation", "cost", "heading_change_rad",
          "iterations", "seconds")  # fmt: skip


def solve_starts(
    problem: Problem,
    starts: int,
    seed: int,
    workers: Workers,
    progress: Progress | None = None,
    folder: str | Path | None = None,
) -> MultiStart:
    """What `optimise.solve.solve` gives, its starts solved by `workers`. Ctrl-C returns the finished ones."""
    check_weights(problem, [problem.task.c])
    solver, c = solver_of(problem), problem.task.c
    gaits = starts_of(solver, starts, seed)
    solver.prepare(gaits[0])
    stores = [store_of(folder, gait) for gait in gaits]
    known = [None if store is None else store.load(c, solver) for store in stores]
    tasks = [(problem, gait, answer) for gait, answer in zip(gaits, known, strict=True)]
    found: dict[int, tuple[Solution, Answer]] = {}
    flag = StopFlag()
    try:
        for index, (solution, answer) in results(one_start, tasks, workers):
            found[index] = solution, answer
            store = stores[index]
            if store is not None and answer.outcome.status.ok and known[index] is None:
                store.save(c, answer)
            if progress is not None:
                progress(len(found), best_of(s for s, _ in found.values()))
    except KeyboardInterrupt:
        if not found:
            raise
        flag.stopped = True
    return with_nearest(solver, summarised(solver, [found[i] for i in sorted(found)], c, flag), flag=flag)


def one_start(problem: Problem, start: Floats, known: Answer | None) -> tuple[Solution, Answer]:
    """One start's answer, certified; `known`: it was solved before."""
    solver, c = _solver(_Asked(problem)), problem.task.c
    answer = solver.solve(start, c) if known is None else known
    return as_solution(solver, answer, c, polish=False), answer


class _Asked:
    """A problem as a key: by its content."""

    def __init__(self, problem: Problem) -> None:
        self.problem, self.key = problem, problem.model_dump_json()

    def __hash__(self) -> int:
        return hash(self.key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Asked) and self.key == other.key


@lru_cache(maxsize=1)
def _solver(asked: _Asked) -> GaitSolver:
    return solver_of(asked.problem)


def write_starts(path: str | Path, result: MultiStart) -> None:
    """One line a start, in their order; `optimum` counts the distinct certified ones from the best, 1, on."""
    first = result.solutions[0]
    names = () if first.problem.family_of(first.gait).free else first.names
    rows = [
        [i, s.status.name.lower(), _rank(s, result.optima), s.trajectory.displacement, s.trajectory.dissipation, s.cost,
         s.trajectory.heading_change, s.iterations, s.seconds, *s.q.tolist()[: len(names)]]
        for i, s in enumerate(result.solutions, 1)
    ]  # fmt: skip
    write_csv(path, [*HEADER, *names], rows)


def _rank(solution: Solution, optima: tuple[Optimum, ...]) -> int | str:
    """Of the optimum this start reached: the one of the nearest objective; empty for a start that reached none."""
    if not solution.status.ok or not optima:
        return ""
    return 1 + min(range(len(optima)), key=lambda i: abs(optima[i].solution.objective - solution.objective))
