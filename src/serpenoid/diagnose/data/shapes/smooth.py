"""Readings about local parabolas: how rough they are, and what a smoother leaves of them.

Legend: R readings, m joints.
"""

from __future__ import annotations

import numpy as np

from serpenoid.body import Floats

SMOOTHED_ROWS = 9
AVERAGED_S = 0.09  # readings and markers are looked at over this time: as the poses at a window's ends are


def scatter(readings: Floats, pooled: bool) -> Floats:
    """RMS of readings (R, m), NaN unknown, about local parabolas [rad], corrected for what they swallow: of each joint
    (m,), or pooled: the median's; NaN where too few are known."""
    squares = np.array([_square(column[np.isfinite(column)]) for column in readings.T])
    return np.asarray(np.sqrt(np.full_like(squares, np.median(squares)) if pooled else squares))


def _square(values: Floats) -> float:
    """Of values (R,) about local parabolas, the mean."""
    if len(values) < SMOOTHED_ROWS:
        return np.nan
    left = values - local_parabolas(values[:, None], SMOOTHED_ROWS)[:, 0]
    return float((left**2).mean() / (1 - 2.25 / SMOOTHED_ROWS))


def local_parabolas(values: Floats, rows: int) -> Floats:
    """Each of `values` (R, m) by the parabola through the `rows` about it (Savitzky and Golay, 1964), R >= rows.

    SciPy's, without its package for signals, whose import takes as long as all others together.
    """
    powers, middle = np.vander(np.arange(rows) - rows // 2, 3), rows // 2
    smoother = powers @ np.linalg.pinv(powers)
    inside = np.lib.stride_tricks.sliding_window_view(values, rows, axis=0) @ smoother[middle]
    return np.concatenate([smoother[:middle] @ values[:rows], inside, smoother[middle + 1 :] @ values[-rows:]])
