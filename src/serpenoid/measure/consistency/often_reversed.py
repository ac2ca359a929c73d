"""A body whose head and tail a tracker confuses so often that no frame tells how far points usually go in one.

    reversed from one frame to the next    if sum |p_{N-1-k}(t) - p_k(t-1)|^2 < sum |p_k(t) - p_k(t-1)|^2

Legend: F frames, N points.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from serpenoid.measure.cells import Floats

CLEARLY = 3.0  # times as near the other way round: no body turns so in a frame
OFTEN = 0.05  # of the frames: mismatches of exchanged points are told one by one where they are fewer
LEAST_POINTS = 3  # that both frames show


def often_reversed(points: Floats) -> tuple[NDArray[np.bool_], float]:
    """Which frames of (F, N, 2) have their points from the other end than most, where that changes in many of them; and
    by how much the least certain of the clear changes is the likelier [nats], 0 where none are told."""
    before, after = points[:-1], points[1:]
    own, other = _apart(before, after), _apart(before, after[:, ::-1])
    clear = other * CLEARLY**2 < own
    if not len(own) or clear.mean() <= OFTEN:
        return np.zeros(len(points), dtype=bool), 0.0
    turned = np.concatenate([[False], np.cumsum(other < own) % 2 == 1])
    gain = points.shape[1] * float(np.log(own[clear] / np.maximum(other[clear], np.finfo(float).tiny)).min())
    return (~turned if turned.mean() > 0.5 else turned), gain


def _apart(before: Floats, after: Floats) -> Floats:
    """Mean squared way of the points that both frames show (F - 1,); NaN of too few."""
    squares = ((after - before) ** 2).sum(axis=2)
    seen = np.isfinite(squares)
    count = seen.sum(axis=1)
    return np.where(count >= LEAST_POINTS, np.where(seen, squares, 0.0).sum(axis=1) / np.maximum(count, 1), np.nan)
