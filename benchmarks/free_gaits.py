"""Free gaits: the robot-snake problems of Inverse Geometric Locomotion from random tables, and L-BFGS beside the NLP.

Every joint angle of every row is free. A seed counts as certified if its KKT conditions hold, step-by-step simulation
agrees, the mesh is fine enough and (obstacles) the clearance is proven; it reaches the best if its objective is within
1e-6 of the best found. L-BFGS-B minimises the same objective over the same angles within the same limits, by the
compiled simulation with adjoint gradients (one sparse solve with the transposed step equations), from the same seeds,
until it is within 1e-6 of the NLP's objective or gives up.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np
from bench import clock, in_units, report, table
from scipy.optimize import minimize
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from serpenoid.optimise.multistart import as_solution
from serpenoid.optimise.solver import Carried, GaitSolver
from serpenoid.optimise.starts import random_gaits
from specimens import problem

SEEDS, RIVALS, CLOSE = 20, 5, 1e-6
PROBLEMS = {
    "reach, w = 10": ("reach",),
    "reach, w = 100": ("reach", "task.c=1.25"),
    "broken joint": ("broken-joint",),
    "turn in a box": ("turn-in-a-box",),
    "disc obstacle": ("disc-obstacle",),
}
FEWER = {"disc obstacle": 3}


@dataclass
class Runs:
    """Processor seconds, iterations, objectives (infinite where not certified) and status words of all seeds."""

    seconds: list[float]
    iterations: list[int]
    objectives: list[float]
    words: list[str]


def solved(words: tuple[str, ...], seeds: int) -> Runs:
    asked = problem(*words)
    solver, runs = GaitSolver(asked), Runs([], [], [], [])
    starts = random_gaits(solver, seeds, seed=0)
    solver.prepare(starts[0])
    for q in starts:
        begin = clock()
        answer = solver.solve(q, asked.task.c)
        runs.seconds.append(clock() - begin)
        found = as_solution(solver, answer, asked.task.c, polish=True)
        runs.iterations.append(answer.iterations)
        runs.objectives.append(found.cost if found.status.ok else np.inf)
        runs.words.append(found.status.name.lower())
    return runs


class Near(Exception):
    """The target was reached."""


def by_lbfgs(words: tuple[str, ...], target: float) -> list[tuple[float, float]]:
    """(seconds, objective above the target) of each seed."""
    asked = problem(*words)
    solver = GaitSolver(asked)
    _, ipopt = solver.prepared(Carried())
    p, n, made = solver.parameters(asked.task.c, ()), 3 * solver.steps, ipopt.functions
    results = []
    for q in random_gaits(solver, RIVALS, seed=0):
        begin, best = clock(), [np.inf]

        def value(angles: np.ndarray, best: list[float] = best) -> tuple[float, np.ndarray]:
            x = solver.start(angles)
            f, slope = made["grad_f"](x, p)
            jacobian = made["jac_g"](x, p)[1].sparse()
            force = splu(csc_matrix(jacobian[:n, :n].T)).solve(slope.full()[:n, 0])
            best[0] = min(best[0], float(f))
            if best[0] <= target + CLOSE:
                raise Near
            return float(f), slope.full()[n:, 0] - jacobian[:n, n:].T @ force

        try:
            options = {"maxiter": 3000, "maxfun": 4000, "maxcor": 30, "ftol": 1e-15, "gtol": 1e-10}
            minimize(
                value,
                q,
                jac=True,
                method="L-BFGS-B",
                bounds=list(zip(*solver.gait_bounds(), strict=True)),
                options=options,
            )
        except Near:
            pass
        results.append((clock() - begin, best[0] - target))
    return results


def main() -> None:
    rows, medians, bests = [], {}, {}
    for name, words in PROBLEMS.items():
        count = FEWER.get(name, SEEDS)
        runs = solved(words, count)
        best = min(runs.objectives)
        reach = sum(o <= best + CLOSE for o in runs.objectives)
        certified = sum(np.isfinite(runs.objectives))
        medians[name], bests[name] = float(np.median(runs.seconds)), best
        failed = ", ".join(sorted({w for w in runs.words if w != "solved"})) or "none"
        rows.append(
            [name, f"{best:.7f}", f"{reach} of {count}", f"{certified} of {count}", failed,
             in_units(medians[name]), in_units(max(runs.seconds)), f"{np.median(runs.iterations):.0f}"]
        )  # fmt: skip
        sys.stderr.write(f"{rows[-1]}\n")
    rivals = by_lbfgs(PROBLEMS["reach, w = 10"], bests["reach, w = 10"])
    took, short = (np.array(x) for x in zip(*rivals, strict=True))
    name = "reach, w = 10"
    ratio = float(np.median(took)) / medians[name]
    targets = [
        ["reach, median of 20 seeds", "0.5 s", in_units(medians[name]), "yes" if medians[name] <= 0.5 else "no"],
        ["reach, beside L-BFGS with adjoint gradients", "20x", f"{ratio:.0f}x", "yes" if ratio >= 20 else "no"],
        ["obstacle and box, median", "3 s", in_units(max(medians["turn in a box"], medians["disc obstacle"])),
         "yes" if max(medians["turn in a box"], medians["disc obstacle"]) <= 3 else "no"],
    ]  # fmt: skip
    report(
        "free_gaits",
        "Free gaits: robot-snake problems from random tables",
        table(["target", "asked", "found", "met"], targets),
        table(
            [
                "problem",
                "best objective",
                "reach the best",
                "certified",
                "otherwise",
                "median",
                "slowest",
                "iterations",
            ],
            rows,
        ),
        f"L-BFGS-B on the reach problem, {RIVALS} seeds: median {in_units(float(np.median(took)))}; "
        f"{int((short <= CLOSE).sum())} of {RIVALS} come within {CLOSE:g} of the optimum, the others end "
        f"{', '.join(f'{s:.1e}' for s in short if s > CLOSE) or 'nowhere else'} above it.",
    )


if __name__ == "__main__":
    main()
