"""The family over 26 values of c, continued from both ends, against 26 cold solves."""

from __future__ import annotations

import numpy as np
from bench import clock, evaluation, in_units, report, table

from serpenoid.optimise.solver import GaitSolver
from serpenoid.optimise.starts import random_gaits
from serpenoid.problem import Problem
from serpenoid.studies.sweep import sweep
from specimens import problem

VALUES, ROUNDS, STARTS = np.linspace(0, 2.5, 26), 3, 4


def cold(asked: Problem, starts: int) -> list[float]:
    """Best cost at every c from `starts` random gaits each; every solve is of its own."""
    solver = GaitSolver(asked)
    gaits = random_gaits(solver, starts, seed=0)
    result = []
    for c in VALUES.tolist():
        answers = [solver.solve(q, c) for q in gaits]
        result.append(min(a.outcome.objective if a.outcome.status.ok else np.inf for a in answers))
    return result


def family(asked: Problem, polish: bool) -> list[float]:
    """Cost at every c by continuation."""
    result = sweep(asked, VALUES, starts=STARTS, seed=0, polish=polish)
    return [p.solution.cost if p.solution is not None else np.inf for p in result.points]


def timed(function) -> tuple[float, list[float]]:  # type: ignore[no-untyped-def]
    begin = clock()
    result = function()
    return clock() - begin, result


def main() -> None:
    rows, targets = [], []
    for name in ("snake10", "reference-optimum"):
        asked = problem(name)
        ways = {
            "continued from both ends, certified": lambda asked=asked: family(asked, True),
            "the same without polishing": lambda asked=asked: family(asked, False),
            "26 cold solves, one start each": lambda asked=asked: cold(asked, 1),
            f"26 cold solves, {STARTS} starts each": lambda asked=asked: cold(asked, STARTS),
        }
        for compiled in (True, False):
            with evaluation(compiled):
                chosen = list(ways.items())[: 4 if compiled else 3]
                repeats = {way: ROUNDS if compiled and "cold" not in way else 1 for way, _ in chosen}
                runs = {way: [timed(function) for _ in range(repeats[way])] for way, function in chosen}
            seconds = {way: min(s for s, _ in run) for way, run in runs.items()}
            costs = {way: np.array(run[0][1]) for way, run in runs.items()}
            best = np.min(list(costs.values()), axis=0)
            word = "compiled" if compiled else "virtual machine"
            for way, took in seconds.items():
                missed = int((costs[way] > best + 1e-6).sum())
                rows.append([name, word, way, in_units(took), f"{missed} of 26"])
            if compiled:
                whole, one, four = (seconds[w] for w in (list(ways)[0], list(ways)[2], list(ways)[3]))
                targets += [
                    [f"{name}: sweep, compiled", "1 s", in_units(whole), "yes" if whole <= 1 else "no"],
                    [
                        f"{name}: against cold, 1 start",
                        "3x",
                        f"{one / whole:.1f}x",
                        "yes" if one >= 3 * whole else "no",
                    ],
                    [
                        f"{name}: against cold, {STARTS} starts (the sweep's own ends)",
                        "3x",
                        f"{four / whole:.1f}x",
                        "yes" if four >= 3 * whole else "no",
                    ],
                ]
    report(
        "sweep",
        "Sweep over 26 values of c",
        table(["target", "asked", "found", "met"], targets),
        "Continuation: fastest of three rounds compiled, otherwise one round, preparing included. Missed: values of c "
        "where another way found a lower cost by more than 1e-6. Cold solves are not certified; the sweep is.",
        table(["problem", "evaluation", "way", "seconds", "missed"], rows),
    )


if __name__ == "__main__":
    main()
