"""Random start gaits, seeded: uniform in the bounds, then shrunk until they respect the joint limits."""

from __future__ import annotations

import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.optimise.solver import GaitSolver


def random_gaits(solver: GaitSolver, count: int, seed: int) -> Floats:
    """`count` gaits within the problem's bounds and limits, shape (count, n)."""
    rng = np.random.default_rng(seed)
    return np.array([_shrink(solver, solver.family.sample(rng)) for _ in range(count)])


def within(solver: GaitSolver, q: Floats, fraction: float) -> tuple[Floats, Floats]:
    """Bounds of +-fraction of each of the gait's own parameters, inside the problem's bounds."""
    if not 0 < fraction <= 1:
        raise InputError(f"`fraction` (--within) must be in (0, 1], got {fraction}. 0.3 is the paper's +-30 %.")
    lower, upper = solver.gait_bounds()
    ends = np.sort(np.stack([q * (1 - fraction), q * (1 + fraction)]), axis=0)
    return np.maximum(lower, ends[0]), np.minimum(upper, ends[1])


def _shrink(solver: GaitSolver, q: Floats) -> Floats:
    """Scale the joint angles of a gait so that all limits hold with 5 % to spare."""
    lower, upper = solver.gait_bounds()
    if not solver.limits.any:
        return np.clip(q, lower, upper)
    finite = np.isfinite(solver.limits.upper)
    excess = solver.excess(solver.tables(q[None]))[0][:, finite]
    ratio = (excess / solver.limits.upper[finite]).max() + 1
    return np.clip(q if ratio <= 1 else solver.family.scaled(q, 0.95 / ratio), lower, upper)
