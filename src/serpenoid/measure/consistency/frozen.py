"""Points that stand to the last digit while all others move: frozen by their tracker, or zeros for what was not seen.

A point stands from one frame to the next if no digit of it changes. It is told where it stands for LEAST_ROWS frames or
more, and the middle one of the others (median) moves meanwhile by more than FAR steps of its file's rounding.

A film hangs where all points that are seen stand, and the middle one then leaps: by more than LEAP times the longest
usual step between frames. A body that rests begins to move as it moves elsewhere.

Legend: F frames, N points.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from serpenoid.measure.cells import Floats, clock
from serpenoid.measure.consistency.signals import LEAST_ROWS
from serpenoid.measure.film.quality import stretches
from serpenoid.wording import counted, some_and_more

FAR = 10.0  # steps of rounding: who turns about a point that rounds alike moves by less
LEAP = 3.0
USUAL = 0.98  # share of steps: the others are a tracker's leaps
NAMED = 3  # points at most


def frozen(points: Floats) -> NDArray[np.int64]:
    """In how many frames each of N points (F, N, 2), NaN hidden, stands while the others move: (N,)."""
    same = (np.diff(points, axis=0) == 0).all(axis=2)
    changes = np.abs(np.diff(points, axis=0))
    moved = changes[changes > 0]
    found = np.zeros(points.shape[1], dtype=np.int64)
    if not moved.size or points.shape[1] < 3:
        return found
    far = FAR * float(moved.min())
    for k in np.flatnonzero(same.any(axis=0)):
        others = np.delete(points, k, axis=1)
        for first, last in stretches(same[:, k]):  # of steps: its last frame is that after its last step
            if last - first + 1 >= LEAST_ROWS and _middle(others[first : last + 1]) > far:
                found[k] += last - first + 1
    return found


def frozen_said(counts: NDArray[np.int64], names: Sequence[str]) -> str | None:
    """Which points stand, and what to do; None: none."""
    which = np.flatnonzero(counts)
    if not len(which):
        return None
    shown = some_and_more([f"`{names[k]}` in {counted(counts[k], 'frame')}" for k in which.tolist()], NAMED)
    return (
        f"to the last digit these markers stand still while the others move: {shown}. Frozen by the tracker, or "
        "zeros for what was not seen? Leave such cells empty in the file"
    )


def hung(points: Floats) -> list[tuple[int, int]]:
    """First and last frame of every stretch in which a film of points (F, N, 2), NaN hidden, hangs."""
    changes = np.linalg.norm(np.diff(points, axis=0), axis=2)
    both = np.isfinite(changes)
    enough = both.sum(axis=1) > 1
    same = ((changes == 0) | ~both).all(axis=1) & enough
    if not same.any():
        return []
    steps = np.full(len(changes), np.nan)
    steps[enough] = [np.median(row[seen]) for row, seen in zip(changes[enough], both[enough], strict=True)]
    moving = steps[np.isfinite(steps) & ~same]
    longest = LEAP * float(np.quantile(moving, USUAL)) if moving.size else np.inf
    return [(first, last) for first, last in stretches(same) if last < len(steps) and steps[last] > longest]


def hung_said(found: Sequence[tuple[int, int]], time_s: Floats) -> str | None:
    """When a film hangs, and what to do; None: never."""
    if not found:
        return None
    moments = [f"{clock(time_s[first])} to {clock(time_s[last])} s" for first, last in found]
    when = some_and_more(moments, NAMED, "more times")
    return (
        f"from {when} no point moves in any digit, and then all leap: did the camera hang? Leave all of these "
        "frames but the first out of the file, or their cells empty"
    )


def _middle(points: Floats) -> float:
    """How far the middle one of some points moves, NaN hidden."""
    seen = np.isfinite(points[..., 0])
    whole = points[:, seen.sum(axis=0) > 1]
    if not whole.shape[1]:
        return 0.0
    extent = (np.nanmax(whole, axis=0) - np.nanmin(whole, axis=0)).max(axis=1)
    return float(np.median(extent))
