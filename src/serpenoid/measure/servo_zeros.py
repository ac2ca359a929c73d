"""Zeros of joints whose angles no frame shows by itself, from all markers together.

The polygon through markers anywhere on the links keeps its bends and its sides whatever the pose: of K corners 2 K - 3
numbers a frame, which every joint between them moves. As a chain of log readings q moves, so do its slopes, and many
frames tell zeros z that no single one does:

    z = (J'J / s^2 + 1 / Z^2)^-1 J' (seen - shown(q)) / s^2,      Z what the zero of a healthy servo is known to

by Gauss-Newton; s^2 is what is left, and what of it lasts longer than a frame. What markers do not tell stays the
log's.

Legend: F frames, K corners, m joints, U joints without an angle.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.body import Body
from serpenoid.measure.cells import Floats
from serpenoid.measure.consistency.match import PHYSICAL
from serpenoid.measure.shapes.links import bends, chain_vertices, wrapped

BELIEVED = PHYSICAL.zero_sd
ROUNDS = 6
STEP = 1e-4  # rad: of differences
MOST_FRAMES = 2000  # more tell nothing that these do not


def told_zeros(
    body: Body, corners: Sequence[int], markers: Floats, angles: Floats, unseen: Sequence[int]
) -> tuple[Floats, Floats]:
    """Zeros (U,) [rad] of joints, and how well they are known, from markers (F, N, 2) beside readings (F, m)."""
    zero, known = np.zeros(len(unseen)), np.full(len(unseen), BELIEVED)
    rows = np.flatnonzero(np.isfinite(markers[:, corners]).all(axis=(1, 2)) & np.isfinite(angles).all(axis=1))
    rows = rows[:: -(-len(rows) // MOST_FRAMES) or 1]
    if len(corners) < 3 or len(rows) < len(unseen):
        return zero, known
    seen = _invariants(markers[rows][:, corners])

    def shown(moved: Floats) -> Floats:
        turned = angles[rows].copy()
        turned[:, list(unseen)] += moved
        return _invariants(chain_vertices(body, np.zeros((len(rows), 3)), turned)[:, corners])

    for _ in range(ROUNDS):
        at = shown(zero)
        left = wrapped(seen - at)  # sides differ by far less than half a turn
        slopes = np.stack([wrapped(shown(zero + STEP * unit) - at) / STEP for unit in np.eye(len(zero))], axis=2)
        variance = float((left**2).mean()) + lasting(left)
        matrix = np.einsum("fku,fkv->uv", slopes, slopes) / variance + np.eye(len(zero)) / BELIEVED**2
        pull = np.einsum("fku,fk->u", slopes, left) / variance - zero / BELIEVED**2
        zero = zero + np.linalg.solve(matrix, pull)
        known = np.sqrt(np.diag(np.linalg.inv(matrix)))
    return zero, known


def _invariants(points: Floats) -> Floats:
    """Bends [rad] of polygons (F, K, 2) [body lengths], and sides in units of a mean one (F, 2 K - 3)."""
    sides = np.linalg.norm(np.diff(points, axis=1), axis=2)
    return np.concatenate([bends(points), sides * (points.shape[1] - 1)], axis=1)


def lasting(difference: Floats) -> float:
    """Twice the sum of autocovariances of columns (F, m), NaN unknown, from lag 1 on [rad^2]: 0 of white noise.

    Pairs of lags while their sum is positive (Geyer, Statistical Science 7, 473, 1992), over a tenth of the record.
    """
    values, found = np.where(np.isfinite(difference), difference, 0.0), 0.0
    count = max(int(np.isfinite(difference).sum()), 1)
    for lag in range(1, max(len(values) // 10, 2), 2):
        pair = sum((values[k:] * values[:-k]).sum() / count for k in (lag, lag + 1))
        if pair <= 0:
            break
        found += 2 * float(pair)
    return found
