"""Random start gaits, seeded: uniform in the bounds, then shrunk until they respect the joint limits."""

from __future__ import annotations

import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.gaits import EllipseGait
from serpenoid.mechanics.tables import joint_table
from serpenoid.optimise.limits import violations
from serpenoid.optimise.solver import GaitSolver

SHAPE = [EllipseGait.NAMES.index(name) for name in ("x_c", "y_c", "a")]
FREE_ANGLE = (-np.pi, np.pi)


def random_gaits(solver: GaitSolver, count: int, seed: int) -> Floats:
    """`count` gaits within the problem's bounds and limits, shape (count, 6)."""
    lower, upper = solver.gait_bounds()
    lower = np.where(np.isfinite(lower), lower, FREE_ANGLE[0])
    upper = np.where(np.isfinite(upper), upper, FREE_ANGLE[1])
    rng = np.random.default_rng(seed)
    return np.array([_shrink(solver, q) for q in rng.uniform(lower, upper, size=(count, 6))])


def within(solver: GaitSolver, q: Floats, fraction: float) -> tuple[Floats, Floats]:
    """Bounds of +-fraction of each of the gait's own parameters, inside the problem's bounds."""
    if not 0 < fraction <= 1:
        raise InputError(f"--within must be in (0, 1], got {fraction}. 0.3 is the paper's +-30 %.")
    lower, upper = solver.gait_bounds()
    ends = np.sort(np.stack([q * (1 - fraction), q * (1 + fraction)]), axis=0)
    return np.maximum(lower, ends[0]), np.minimum(upper, ends[1])


def _shrink(solver: GaitSolver, q: Floats) -> Floats:
    """Scale the curvature of a gait (joint angles are linear in it) so that all limits hold with 5 % to spare."""
    if not solver.limits.any:
        return q
    finite = np.isfinite(solver.limits.upper)
    limit = solver.limits.upper[finite]
    excess = violations(joint_table(solver.model, q, solver.steps), solver.limits)[:, finite]
    ratio = (excess / limit).max() + 1
    if ratio <= 1:
        return q
    shrunk = q.copy()
    lower, upper = solver.gait_bounds()
    shrunk[SHAPE] = np.clip(q[SHAPE] * 0.95 / ratio, lower[SHAPE], upper[SHAPE])
    return shrunk
