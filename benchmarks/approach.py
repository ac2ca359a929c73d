"""What the constants of hard problems are worth: how a search is approached, and what it watches beside obstacles.

Every constant of `optimise/easier.py` and `optimise/watch.py` at its value and at others, the rest as they are: the
reach problem for the rows of the rough table, the disc obstacle for the others. A seed counts as certified as in
`free_gaits.py`. Ratios are of processor seconds to those with the package's own values, the same seeds, each seed with
all values in turn.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from unittest.mock import patch

import numpy as np
from bench import clock, report, table

from serpenoid.optimise import easier, watch
from serpenoid.optimise.multistart import as_solution
from serpenoid.optimise.prepared import Carried, PreparedNLPs
from serpenoid.optimise.solver import GaitSolver
from serpenoid.optimise.starts import random_gaits
from specimens import problem

CLOSE = 1e-6
REACH, DISC = ("reach", 8), ("disc-obstacle", 3)  # problems and how many seeds
NO_ROUGH = 10**6  # LEAST rows that no table has
OWN: dict[str, float] = {}
CASES: dict[str, tuple[tuple[str, int], list[dict[str, float]]]] = {
    "rows of the rough table (FEWER, LEAST)": (
        REACH,
        [{"LEAST": NO_ROUGH}, {"FEWER": 2}, OWN, {"FEWER": 8, "LEAST": 10}],
    ),
    "rows of the rough table, disc": (DISC, [{"FEWER": 2}, OWN, {"FEWER": 8}]),
    "what is near (NEAR)": (DISC, [{"NEAR": 0.1}, OWN, {"NEAR": 1.0}]),
    "what is kept (MARGIN)": (DISC, [{"MARGIN": 1e-4}, OWN, {"MARGIN": 1e-2}]),
    "what is watched then (DEEP)": (DISC, [{"DEEP": 1e-3}, OWN, {"DEEP": 2e-2}]),
}


@dataclass(frozen=True)
class Run:
    """Processor seconds, iterations, objective (None: not certified)."""

    seconds: float
    iterations: int
    objective: float | None


@contextmanager
def using(values: dict[str, float]) -> Iterator[None]:
    """Inside: constants have other values."""
    first = PreparedNLPs.first

    def with_margin(solver: PreparedNLPs) -> Carried:
        return replace(first(solver), margin=values["MARGIN"])

    with ExitStack() as stack:
        for name, value in values.items():
            if name == "MARGIN":
                stack.enter_context(patch.object(PreparedNLPs, "first", with_margin))
            else:
                stack.enter_context(patch.object(easier if hasattr(easier, name) else watch, name, value))
        yield


def solved(solver: GaitSolver, q: np.ndarray) -> Run:
    """One start, certified."""
    c = solver.problem.task.c
    begin = clock()
    answer = solver.solve(q, c)
    took = clock() - begin
    found = as_solution(solver, answer, c, polish=True)
    return Run(took, answer.iterations, found.cost if found.status.ok else None)


def runs(name: str, seeds: int, cases: list[dict[str, float]]) -> list[list[Run]]:
    """Of every case, all seeds; each seed with all cases in turn."""
    solvers = []
    for values in cases:
        with using(values):
            solvers.append(GaitSolver(problem(name)))
    gaits = random_gaits(solvers[0], seeds, seed=0)
    found: list[list[Run]] = [[] for _ in cases]
    for q in gaits:
        for values, solver, into in zip(cases, solvers, found, strict=True):
            with using(values):
                if not into:
                    solver.prepare(q)
                into.append(solved(solver, q))
                sys.stderr.write(f"{name} {values}: {into[-1]}\n")
    return found


def value_of(values: dict[str, float]) -> str:
    """A case in words."""
    if values == {"LEAST": NO_ROUGH}:
        return "no rough table"
    return ", ".join(f"{name} = {value:g}" for name, value in values.items()) or "**as it is**"


def rows(title: str, about: tuple[str, int], cases: list[dict[str, float]]) -> list[list[str]]:
    """Lines of the table."""
    name, seeds = about
    found = runs(name, seeds, cases)
    best = min((r.objective for case in found for r in case if r.objective is not None), default=np.inf)
    own = sum(r.seconds for r in found[cases.index(OWN)])
    lines = []
    for values, case in zip(cases, found, strict=True):
        good = [r.objective for r in case if r.objective is not None]
        reach = sum(o <= best + CLOSE for o in good)
        worst = f"{max(good) - best:.1e}" if good else ""
        ratio, iterations = sum(r.seconds for r in case) / own, np.mean([r.iterations for r in case])
        counts = [f"{len(good)} of {seeds}", f"{reach} of {seeds}", worst]
        lines.append([title, name, value_of(values), f"{ratio:.2f}", f"{iterations:.0f}", *counts])
    return lines


def main() -> None:
    lines = [line for title, (about, cases) in CASES.items() for line in rows(title, about, cases)]
    own = f"FEWER = {easier.FEWER}, LEAST = {easier.LEAST}, NEAR = {watch.NEAR:g}, MARGIN = {watch.MARGIN:g}, "
    header = ["constant", "problem", "value", "time", "iterations", "certified", "reach the best", "worst above best"]
    report(
        "approach",
        "What the constants of hard problems are worth",
        own + f"DEEP = {watch.DEEP:g}. Time: ratio to the package's own values.",
        table(header, lines),
    )


if __name__ == "__main__":
    main()
