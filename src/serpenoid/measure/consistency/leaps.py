"""Bodies that leap: in one frame the middle of all markers moves by many body lengths, which no body does.

Another body was tracked, or positions are of another unit, or run away. Gaps count by the frames that they last.

Legend: F frames, N markers, tail first.
"""

from __future__ import annotations

import warnings

import numpy as np

from serpenoid.measure.cells import Floats, clock

LEAP = 10.0  # body lengths in a frame; the fastest fish make one in a frame of a slow camera


def leap(points: Floats, time_s: Floats) -> str | None:
    """Where markers (F, N, 2), NaN hidden, leap first, and how far; None: nowhere."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of frames and neighbours that are never seen
        middle = np.nanmedian(points, axis=1)
        length = float(np.nansum(np.nanmedian(np.linalg.norm(np.diff(points, axis=1), axis=2), axis=0)))
    seen = np.flatnonzero(np.isfinite(middle[:, 0]))
    if len(seen) < 2 or not length > 0:
        return None
    moved = np.linalg.norm(np.diff(middle[seen], axis=0), axis=1) / np.diff(seen) / length
    far = np.flatnonzero(moved > LEAP)
    if not len(far):
        return None
    return f"leap at {clock(time_s[seen[far[0] + 1]])} s by {moved[far[0]]:.2g} body lengths a frame"
