"""Whether a chain crosses itself: the model has no self-contact, a robot does."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from serpenoid.body import Floats
from serpenoid.wording import counted

HALF = float(np.finfo(float).eps) / 2
ORIENTATION = (3 + 16 * HALF) * HALF  # what rounding makes of it: Shewchuk 1997, ccwerrboundA

if TYPE_CHECKING:
    from serpenoid.trajectory import Trajectory


def crosses_itself(vertices: Floats) -> np.ndarray:
    """Which chains (R, N, 2) have two edges that cross: no real body can take such a shape; shape (R,)."""
    return np.array([_has_crossing(chain) for chain in vertices], bool)


def _has_crossing(chain: Floats) -> bool:
    """Whether edges of a chain (N, 2) cross: the sides of every vertex from every edge, each found once."""
    side = _side(chain[:-1, None], chain[1:, None], chain[None])
    parted = side[:, :-1] * side[:, 1:] < 0  # of edge i: whether the ends of edge j lie on its two sides
    return bool(np.triu(parted & parted.T, k=2).any())


def crosses(a: Floats, b: Floats, c: Floats, d: Floats) -> np.ndarray:
    """Which pieces a-b and c-d of lines cross, points (..., 2), shape (...)."""
    apart = _side(a, b, c) * _side(a, b, d) >= 0
    return np.asarray(~apart & (_side(c, d, a) * _side(c, d, b) < 0))


def _side(a: Floats, b: Floats, p: Floats) -> Floats:
    """On which side of the line a-b the point p lies, by sign; 0 where rounding does not tell."""
    along, to = b - a, p - a
    one, other = along[..., 0] * to[..., 1], along[..., 1] * to[..., 0]
    side = one - other
    return np.where(np.abs(side) > ORIENTATION * (np.abs(one) + np.abs(other)), side, 0.0)


def crossing_rows(trajectory: Trajectory) -> int:
    """In how many rows of the table the chain crosses itself: no real body can play those."""
    rows = trajectory.vertices[: trajectory.steps_per_cycle, :, :2]
    return int(crosses_itself(rows).sum()) if np.isfinite(rows).all() else 0


def crossing_warning(trajectory: Trajectory) -> list[str]:
    """A line for the user where the gait cannot be played, else nothing."""
    rows = crossing_rows(trajectory)
    remedy = "lower the joint limits or the amplitude, or raise c"
    return (
        [f"warning           the body crosses itself in {counted(rows, 'row')} of the table: {remedy}"] if rows else []
    )
