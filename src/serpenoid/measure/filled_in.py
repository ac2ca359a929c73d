"""Filled in: points that somebody's program put on a straight line between two frames in which they were seen.

On such a line second differences are zero to the file's rounding, which measured points' hardly ever are:

    d(f, k) = p(f + 1, k) - 2 p(f, k) + p(f - 1, k),    |d_x|, |d_y| <= r:  4 roundings, or of a number without digits
                                                                           of its own that of 32 bits,

between two frames in which they are beyond 2 r. Frame after frame so, for n of them, comes about by chance, too: the
more often, the less noise and motion there is. But then a bound of 2 r holds twice as many points as one of r does, and
four times as many if they are noise. Where it holds hardly any more, a third of these being FALSE of all, by the least
n for which that is so, they are no chance. A point that stands is none of them (`consistency.frozen`), nor is one whose
neighbours in time are not one frame away.

Filled-in points are hidden, as in a file that leaves such cells empty, and frames that show nothing else are left out.

Legend: F frames, M markers.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from serpenoid.measure.cells import Floats
from serpenoid.measure.quality import stretches
from serpenoid.measure.tracks import Tracks

FALSE = 0.01  # of the points that are hidden: stated
LONGEST = 32  # frames: a stretch that needs more to stand out is not told from a slow motion
ROUNDINGS = 4.0  # 1 + 2 + 1 halves of a step, and as much for how the line was made
DIGITS = 12  # decimal digits of a metre, or a pixel, that are looked for
MET = 0.01  # of a rounding: numbers are at it by chance as seldom
SINGLE = float(np.finfo(np.float32).eps)
EVEN = 0.01  # of the usual time between frames


def without_filled_in(tracks: Tracks) -> tuple[Tracks, str]:
    """Tracks whose filled-in points are hidden, and what is said of them; else ''."""
    made = _filled_in(tracks)
    if not made.any():
        return tracks, ""
    hidden = made & tracks.seen
    gone = hidden.any(axis=1) & (hidden == tracks.seen).all(axis=1)
    floor = np.where(hidden[..., None], np.nan, tracks.floor)
    space = None if tracks.space is None else np.where(hidden[..., None], np.nan, tracks.space)[~gone]
    frames = f", in {gone.sum()} of {len(gone)} frames all" if gone.any() else ""
    return replace(tracks, time_s=tracks.time_s[~gone], floor=floor[~gone], space=space), (
        f"{hidden.sum() / tracks.seen.sum():.1%} of its points are on straight lines between frames, to the last "
        f"digit{frames}: filled in by a program, not seen. They are hidden; leave such cells empty in the file"
    )


def _filled_in(tracks: Tracks) -> NDArray[np.bool_]:
    """Which points (F, M) are."""
    floor, found = tracks.floor, np.zeros(tracks.seen.shape, dtype=bool)
    if len(floor) < 3:
        return found
    away = np.abs(np.diff(floor, n=2, axis=0)).max(axis=2)  # (F - 2, M), NaN: not seen
    steps = np.diff(tracks.time_s)
    usual = np.abs(steps / np.median(steps) - 1) < EVEN
    away[~(usual[1:] & usual[:-1])] = np.nan
    r = rounded_by(floor)
    moves = np.abs(np.diff(floor, axis=0)).max(axis=2) > r
    moving = moves[1:] & moves[:-1]
    lasts = _between_kinks(moving & (away <= 2 * r), away > 2 * r)
    for least in range(1, LONGEST + 1):
        lines = (lasts >= least) & (away <= r)
        if (1 + ((lasts >= least) & ~lines).sum()) / 3 <= FALSE * lines.sum():
            found[1:-1] = lines
            break
    return found


def _between_kinks(straight: NDArray[np.bool_], kinked: NDArray[np.bool_]) -> NDArray[np.int64]:
    """How many frames long the stretch is in which each point (F, M) is straight, next to frames in which it is kinked;
    0: none. Where the film begins or ends, no longer than elsewhere."""
    found, beside = np.zeros(straight.shape, dtype=np.int64), []
    for k, column in enumerate(straight.T):
        for first, last in stretches(column):
            ends = kinked[[first - 1] * (first > 0) + [last] * (last < len(column)), k]
            if len(ends) == 2 and ends.all():
                found[first:last, k] = last - first
            elif len(ends) == 1 and ends.all():
                beside.append((first, last, k))
    longest = found.max(initial=0)
    for first, last, k in beside:
        found[first:last, k] = (last - first) * (last - first <= longest)
    return found


def rounded_by(points: Floats) -> float:
    """What second differences of points (...) on a line may be from rounding: of decimal digits, else of 32 bits."""
    values = points[np.isfinite(points)]
    largest = float(np.abs(values).max(initial=0.0))
    for digits in range(DIGITS + 1):
        step = 10.0**-digits
        unsure = 8 * np.finfo(float).eps * largest / step  # of a number in 64 bits
        if unsure > MET:
            break
        if (np.abs(values / step - np.round(values / step)) <= max(1e-6, unsure)).all():
            return ROUNDINGS * step / 2
    return ROUNDINGS * SINGLE * largest
