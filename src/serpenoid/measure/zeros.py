"""Points at exactly (0, 0): how some trackers write that they did not see a point.

A body may pass through the origin, or begin in it; it does not leap there and back. A visit to the origin counts as
`not seen` where the point comes from farther away, and goes farther away, than FAR of its own longest usual step
between frames. Where that happens more than once in a recording, or for LONG frames, all that is at (0, 0) is hidden.

Legend: F frames, M points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from serpenoid.measure.cells import Floats
from serpenoid.measure.quality import stretches
from serpenoid.measure.tracks import Tracks

FAR = 3.0
LONG = 8  # frames: as long as what is told of a marker that stands
USUAL = 0.98  # share of a point's steps: the others are a tracker's leaps
NAMED = 3  # points at most


def without_zeros(tracks: Tracks) -> tuple[Tracks, str]:
    """Tracks whose points at exactly (0, 0) are hidden where that says `not seen`, and which these were; else ''."""
    there = (tracks.floor == 0).all(axis=2)
    leaps = [last - first for k in range(there.shape[1]) for first, last in _leaps(tracks.floor[:, k], there[:, k])]
    if len(leaps) < 2 and max(leaps, default=0) < LONG:
        return tracks, ""
    hidden = np.where(there[..., None], np.nan, tracks.floor)
    space = None if tracks.space is None else np.where(there[..., None], np.nan, tracks.space)
    return replace(tracks, floor=hidden, space=space), _said(there, tracks.names)


def _leaps(path: Floats, there: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Stretches of frames in which one point (F, 2) is in the origin and was not on its way there."""
    seen = np.flatnonzero(np.isfinite(path[:, 0]) & ~there)
    steps = np.linalg.norm(np.diff(path[seen], axis=0), axis=1) / np.diff(seen)  # a frame
    if not there.any() or not len(seen):
        return []
    moving = steps[steps > 0]
    longest = FAR * float(np.quantile(moving, USUAL)) if len(moving) else 0.0
    return [(first, last) for first, last in stretches(there) if _away(path, seen, first, last) > longest]


def _away(path: Floats, seen: NDArray[np.int64], first: int, last: int) -> float:
    """How far a point comes and goes, a frame, between the origin and the nearest frame that shows it: the less."""
    at = int(np.searchsorted(seen, first))
    beside = [(seen[i], abs(seen[i] - frame)) for i, frame in ((at - 1, first), (at, last - 1)) if 0 <= i < len(seen)]
    return min(float(np.linalg.norm(path[k])) / apart for k, apart in beside)


def _said(there: NDArray[np.bool_], names: Sequence[str]) -> str:
    counts = there.sum(axis=0)
    which = np.flatnonzero(counts)
    shown = ", ".join(f"`{names[k]}` in {counts[k]} frames" for k in which[:NAMED])
    more = f" and {len(which) - NAMED} more" if len(which) > NAMED else ""
    return (
        f"{there.mean():.1%} of its points are at exactly (0, 0), where no marker leaps to and back: {shown}{more}. "
        "Taken for not seen, and hidden; leave such cells empty in the file"
    )
