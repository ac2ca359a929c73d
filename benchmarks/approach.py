"""What the constants of hard problems are worth: how a search is approached, and what it watches beside obstacles.

Every constant of `optimise/easier.py`, `optimise/clear/watch.py` at its value and others, the rest as they are: the
reach problem for the rows of the rough table, dry ground for softer friction, the disc obstacle for what is watched;
for ellipses the rows that carry limits at first; and how many iterations IPOPT looks ahead, for free gaits that keep
off themselves or stay in a corridor. A seed counts as certified as in `free_gaits.py`. Ratios are of processor seconds
to those with the package's own values, the same seeds, each seed with all values in turn.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from unittest.mock import patch

import numpy as np
from bench import clock, report, table

from serpenoid.optimise import easier, ipopt
from serpenoid.optimise.clear import watch
from serpenoid.optimise.multistart import as_solution
from serpenoid.optimise.program import prepared
from serpenoid.optimise.program.prepared import Carried, PreparedNLPs
from serpenoid.optimise.robust import solver_of
from serpenoid.optimise.solver import GaitSolver
from serpenoid.optimise.starts import random_gaits
from specimens import problem

CLOSE = 1e-6
SMALL = "reach", "body.vertices=6", "task.steps=40"
BENDING = '{kind="bending",weight=WEIGHT},{kind="position",target=PLACE,weight=5.0}'


def goal(weight: str, place: str) -> str:
    """A place to reach with little bending."""
    return f"task.objectives=[{BENDING.replace('WEIGHT', weight).replace('PLACE', place)}]"


def off_itself(weight: str) -> tuple[str, ...]:
    """Free tables whose links may cross, but for one demand."""
    apart = 'task.demands=[{kind="self",distance=0.03}]'
    return *SMALL, "body.joint_limit_deg=150", apart, goal(weight, "[0.5,0.0]")


def in_corridor(weight: str) -> tuple[str, ...]:
    """From rest to rest round a bend."""
    line = "[[-1.0,0.0],[0.6,0.0],[1.5,0.4]]"
    room = f'task.demands=[{{kind="corridor",line={line},half_width=0.15}}]'
    return *SMALL, "task.c=0.3", "task.transient=true", room, goal(weight, "[0.7,0.1]")


DRY = "reference-optimum", 'medium.law="coulomb"', "task.steps=40", "task.c=1.0"
# problems and how many seeds
REACH, DISC, FRICTION = (("reach",), 8), (("disc-obstacle",), 3), (DRY, 4)
AHEAD = "watchdog_trial_iter_max"
NO_ROUGH = 10**6  # LEAST rows that no table has
OWN: dict[str, float] = {}
CASES: dict[str, tuple[tuple[tuple[str, ...], int], list[dict[str, float]]]] = {
    "rows of the rough table (FEWER, LEAST)": (
        REACH,
        [{"LEAST": NO_ROUGH}, {"FEWER": 2}, OWN, {"FEWER": 8, "LEAST": 10}],
    ),
    "rows of the rough table, disc": (DISC, [{"FEWER": 2}, OWN, {"FEWER": 8}]),
    "what is near (NEAR)": (DISC, [{"NEAR": 0.1}, OWN, {"NEAR": 1.0}]),
    "what is kept (MARGIN)": (DISC, [{"MARGIN": 1e-4}, OWN, {"MARGIN": 1e-2}]),
    "what is watched then (DEEP)": (DISC, [{"DEEP": 1e-3}, OWN, {"DEEP": 2e-2}]),
    **{
        f"rows that carry limits at first (FIRST_ROWS), {name}": (
            ((name,), 12),
            [{"FIRST_ROWS": 3}, {"FIRST_ROWS": 5}, OWN, {"FIRST_ROWS": 20}],
        )
        for name in ("reference-optimum", "snake10")
    },
    "softer friction (SOFTER, SOFTEST)": (
        FRICTION,
        [{"SOFTER": 10**0.25}, OWN, {"SOFTER": 10.0}, {"SOFTEST": 0.1}, {"SOFTEST": 10.0}, {"SOFTEST": 0.0}],
    ),
    **{
        f"iterations ahead ({AHEAD}), off itself, bending {weight}": (
            (off_itself(weight), 5),
            [{AHEAD: 3}, {AHEAD: 5}, OWN, {AHEAD: 20}],
        )
        for weight in ("0.0", "1e-4", "1e-3", "1e-2")
    },
    **{
        f"iterations ahead ({AHEAD}), corridor, bending {weight}": ((in_corridor(weight), 5), [{AHEAD: 3}, OWN])
        for weight in ("0.0", "1e-4", "1e-3", "1e-2")
    },
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
            elif name == AHEAD:
                stack.enter_context(patch.dict(ipopt.OPTIONS, {f"ipopt.{name}": int(value)}))
            else:
                place = next(module for module in (easier, watch, prepared) if hasattr(module, name))
                stack.enter_context(patch.object(place, name, value))
        yield


def solved(solver: GaitSolver, q: np.ndarray) -> Run:
    """One start, certified."""
    c = solver.problem.task.c
    begin = clock()
    answer = solver.solve(q, c)
    took = clock() - begin
    found = as_solution(solver, answer, c, polish=True)
    return Run(took, answer.iterations, found.cost if found.status.ok else None)


def runs(spec: tuple[str, ...], seeds: int, cases: list[dict[str, float]]) -> list[list[Run]]:
    """Of every case, all seeds; each seed with all cases in turn."""
    solvers = []
    for values in cases:
        with using(values):
            solvers.append(solver_of(problem(*spec)))
    gaits = random_gaits(solvers[0], seeds, seed=0)
    found: list[list[Run]] = [[] for _ in cases]
    for q in gaits:
        for values, solver, into in zip(cases, solvers, found, strict=True):
            with using(values):
                if not into:
                    solver.prepare(q)
                into.append(solved(solver, q))
                sys.stderr.write(f"{spec} {values}: {into[-1]}\n")
    return found


def value_of(values: dict[str, float]) -> str:
    """A case in words."""
    if values == {"LEAST": NO_ROUGH}:
        return "no rough table"
    if values == {"SOFTEST": 0.0}:
        return "from linear drag at once"
    return ", ".join(f"{name} = {value:g}" for name, value in values.items()) or "**as it is**"


def rows(title: str, about: tuple[tuple[str, ...], int], cases: list[dict[str, float]]) -> list[list[str]]:
    """Lines of the table."""
    spec, seeds = about
    found = runs(spec, seeds, cases)
    best = min((r.objective for case in found for r in case if r.objective is not None), default=np.inf)
    own = sum(r.seconds for r in found[cases.index(OWN)])
    lines = []
    for values, case in zip(cases, found, strict=True):
        good = [r.objective for r in case if r.objective is not None]
        reach = sum(o <= best + CLOSE for o in good)
        worst = f"{max(good) - best:.1e}" if good else ""
        ratio, iterations = sum(r.seconds for r in case) / own, np.mean([r.iterations for r in case])
        counts = [f"{len(good)} of {seeds}", f"{reach} of {seeds}", worst]
        lines.append([title, spec[0], value_of(values), f"{ratio:.2f}", f"{iterations:.0f}", *counts])
    return lines


def main() -> None:
    lines = [line for title, (about, cases) in CASES.items() for line in rows(title, about, cases)]
    own = f"FEWER = {easier.FEWER}, LEAST = {easier.LEAST}, NEAR = {watch.NEAR:g}, MARGIN = {watch.MARGIN:g}, "
    header = ["constant", "problem", "value", "time", "iterations", "certified", "reach the best", "worst above best"]
    report(
        "approach",
        "What the constants of hard problems are worth",
        own + f"DEEP = {watch.DEEP:g}, SOFTER = {easier.SOFTER:.3g}, SOFTEST = {easier.SOFTEST:g}, "
        f"FIRST_ROWS = {prepared.FIRST_ROWS}, "
        f"{AHEAD} = {ipopt.OPTIONS[f'ipopt.{AHEAD}']} (IPOPT's own 3). Time: ratio to the package's own values.",
        table(header, lines),
    )


if __name__ == "__main__":
    main()
