"""A hundred random starts: which certified optima there are, how often each is reached, and how many starts fail."""

from __future__ import annotations

from collections import Counter

from bench import clock, in_units, report, table

from serpenoid.optimise.multistart import solve_many
from serpenoid.optimise.solver import GaitSolver
from serpenoid.optimise.starts import random_gaits
from specimens import problem

STARTS, SEED = 100, 6
PROBLEMS = {
    "reference-optimum": ("reference-optimum",),
    "reference-optimum, c = 1": ("reference-optimum", "task.c=1.0"),
    "reference-optimum, straight": ("reference-optimum", "task.constraints.straight=true"),
    "snake10": ("snake10",),
    "snake10, c = 1": ("snake10", "task.c=1.0"),
    "gait-c": ("gait-c",),
    "purcell": ("purcell",),
}


def main() -> None:
    rows = []
    for name, words in PROBLEMS.items():
        asked = problem(*words)
        solver = GaitSolver(asked)
        begin = clock()
        result = solve_many(solver, random_gaits(solver, STARTS, SEED), asked.task.c)
        took = clock() - begin
        optima = ", ".join(f"{o.solution.cost:.6f} ({o.count})" for o in result.optima)
        failed = Counter(s.status.name for s in result.failures)
        words_failed = ", ".join(f"{status} {count}" for status, count in failed.items()) or "none"
        rows.append([name, result.optima[0].count if result.optima else 0, optima, words_failed, in_units(took)])
    failures = "none" if all(row[3] == "none" for row in rows[:1]) else rows[0][3]
    target = ["failed starts on the reference optimum", "none", failures, "yes" if failures == "none" else "no"]
    report(
        "many_starts",
        f"{STARTS} random starts, seed {SEED}",
        table(["target", "asked", "found", "met"], [target]),
        "Certified local optima as cost (starts). Seconds include preparing, certificates and polishing.",
        table(["problem", "reach the best", "certified optima", "failed", "seconds"], rows),
    )


if __name__ == "__main__":
    main()
