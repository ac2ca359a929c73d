"""A recording in which nothing moves: told at once, since nothing can be told from it."""

from __future__ import annotations

import numpy as np

from serpenoid.measure.cells import Floats
from serpenoid.measure.consistency.signals import LEAST_ROWS, Signal


def nothing_moved(time_s: Floats, markers: Floats) -> str | None:
    """What to say where not one of the markers (F, N, 2), NaN hidden, moves by more than its noise from frame to frame.

    A body that bends where it lies moves its markers, and so does one that is slow: frames in a row are alike then.
    """
    tracks = [Signal(time_s, markers[:, k]) for k in range(markers.shape[1])]
    seen = [track for track in tracks if track.known.sum() >= LEAST_ROWS]
    if not seen or any(track.moves for track in seen):
        return None
    return (
        f"nothing moved: no marker leaves its place by more than its noise in the {np.ptp(time_s):.3g} s that were "
        "recorded. Was the power off, or the recording over before the motion began? Record it again, or leave "
        "this trial out"
    )
