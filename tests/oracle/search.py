"""Derivative-free optimisation over the gait ellipse, with any callable as the simulation.

x = (sigma, a, x_c, y_c, theta, xi). A violated limit costs more than any feasible gait can earn, and more the worse it
is violated, so that both searches find their way back.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import differential_evolution, minimize

from oracle.chain import Floats, serpenoid_joint_table
from oracle.integrator import simulate

NAMES = ("sigma", "a", "x_c", "y_c", "theta", "xi")
REFERENCE_BOUNDS = {
    "sigma": (0.0, 1.0),
    "a": (0.0, 15.0),
    "x_c": (-6.0, 6.0),
    "y_c": (-6.0, 6.0),
    "theta": (-np.pi, np.pi),
    "xi": (0.5, 2.5),
}


@dataclass(frozen=True)
class Found:
    """The best gait by name, its cost, and how often the simulation ran."""

    gait: dict[str, float]
    cost: float
    evaluations: int


def joint_limit_excess(joint_table: ArrayLike, limit: float) -> float:
    """By how much the worst joint angle exceeds the limit [rad]; 0 if none does."""
    return float(max(0.0, np.abs(joint_table).max() - limit))


def oracle_cost(
    gait: Mapping[str, float],
    *,
    edge_lengths: ArrayLike,
    weights: ArrayLike,
    eps: float,
    steps: int,
    c: float = 0.0,
    joint_limit: float = np.inf,
) -> float:
    """-displacement + c * dissipation by the oracle's own simulation."""
    table = serpenoid_joint_table(edge_lengths, steps, **gait)
    excess = joint_limit_excess(table, joint_limit)
    if excess > 0:
        return 10.0 + excess
    run = simulate(table, edge_lengths, weights, eps)
    return -run.displacement + c * run.dissipation


class _Counted:
    def __init__(self, cost: Callable[[dict[str, float]], float], bounds: Mapping[str, tuple[float, float]]):
        self.cost, self.calls = cost, 0
        self.low, self.high = (np.array([bounds[n][i] for n in NAMES]) for i in (0, 1))

    def __call__(self, x: Floats) -> float:
        self.calls += 1
        outside = float(np.maximum(self.low - x, 0).sum() + np.maximum(x - self.high, 0).sum())
        if outside > 0:
            return 20.0 + outside
        return float(self.cost(dict(zip(NAMES, map(float, x), strict=True))))

    def found(self, x: Floats) -> Found:
        return Found(dict(zip(NAMES, map(float, x), strict=True)), self(x), self.calls)


def polish(
    cost: Callable[[dict[str, float]], float],
    start: Mapping[str, float],
    bounds: Mapping[str, tuple[float, float]] = REFERENCE_BOUNDS,
    *,
    evaluations: int = 3000,
    restarts: int = 2,
) -> Found:
    """Nelder-Mead from `start`, restarted from its own end point in case the simplex collapsed."""
    counted = _Counted(cost, bounds)
    x = np.array([start[n] for n in NAMES])
    for _ in range(1 + restarts):
        options = {"maxfev": evaluations // (1 + restarts), "xatol": 1e-9, "fatol": 1e-12, "adaptive": True}
        end = minimize(counted, x, method="Nelder-Mead", options=options)
        x = end.x
    return counted.found(x)


def global_search(
    cost: Callable[[dict[str, float]], float],
    bounds: Mapping[str, tuple[float, float]] = REFERENCE_BOUNDS,
    *,
    seed: int = 0,
    population: int = 10,
    generations: int = 100,
    polish_evaluations: int = 3000,
) -> Found:
    """Differential evolution, then Nelder-Mead from its best."""
    counted = _Counted(cost, bounds)
    box = list(zip(counted.low, counted.high, strict=True))
    end = differential_evolution(
        counted, box, popsize=population, maxiter=generations, rng=seed, polish=False, tol=1e-8
    )
    best = dict(zip(NAMES, map(float, end.x), strict=True))
    polished = polish(cost, best, bounds, evaluations=polish_evaluations)
    return Found(polished.gait, polished.cost, polished.evaluations + counted.calls)
