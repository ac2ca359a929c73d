"""Gaits by derivative-free search: starts for models on which the gait NLP seldom converges; nothing certifies them.

Random trial gaits about the best so far, at distances that grow after a gain and shrink without one: an evolution
strategy with one parent. Each generation is one batch of forward simulations.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.body import Floats
from serpenoid.gaits import Gait
from serpenoid.optimise.certify import gait_costs
from serpenoid.optimise.solver import GaitSolver
from serpenoid.problem import Problem

GENERATIONS, CHILDREN = 120, 16
FIRST, LEAST = 5.0, 0.02  # distances, in widths
GROW, SHRINK = 1.5, 0.75
PENALTY = 100.0


def search(problem: Problem, begins: Sequence[Gait], seed: int = 0) -> tuple[Gait, float]:
    """The best gait within the problem's limits found from the given ones (of one family), and its cost."""
    solver = GaitSolver(problem, gait=begins[0])
    starts = [problem.family_of(gait).start() for gait in begins]
    found = [_from(solver, problem.task.c, q, np.random.default_rng(seed)) for q in starts]
    q, cost = min(found, key=lambda f: f[1])
    return solver.family.gait(q), cost


def _from(solver: GaitSolver, c: float, q: Floats, rng: np.random.Generator) -> tuple[Floats, float]:
    lower, upper = bounds = solver.gait_bounds()
    width = np.where(upper > lower, solver.family.widths, 0.0)
    best, distance = np.clip(q, lower, upper), FIRST
    lowest = float(gait_costs(solver, best[None], c, PENALTY, bounds)[0])
    for _ in range(GENERATIONS):
        trials = np.clip(best + distance * width * rng.standard_normal((CHILDREN, best.size)), lower, upper)
        costs = gait_costs(solver, trials, c, PENALTY, bounds)
        if costs.min() < lowest:
            lowest, best, distance = float(costs.min()), trials[costs.argmin()], distance * GROW
        else:
            distance = max(distance * SHRINK, LEAST)
    return best, lowest
