"""Filled in: points that somebody's program put on a straight line between two frames in which they were seen.

On such a line second differences are zero to the file's rounding, which measured points' hardly ever are:

    d(f, k) = p(f + 1, k) - p(f, k) - h (p(f, k) - p(f - 1, k)),    |d_x|, |d_y| <= r:  two steps of the file, or of
                                                                                       numbers of 32 bits four

between two frames in which they are beyond 2 r, and none of its points is farther than r from the chord of the whole.
h: 1, or how long the one step of time is over the other, by which more are so. Frame after frame so, for n of them,
comes about by chance, too: the more often, the less noise and motion there is. But then a bound of 2 r holds twice as
many points as one of r does, and four times as many if they are noise. Where it holds hardly any more, a third of these
being FALSE of all, by the least n for which that is so, they are no chance. Where seen points scatter by no more than
the file's steps, a body that moves steadily is on lines, too, and nothing is told. A point that stands is none of them
(`consistency.frozen`), nor is one beside a frame that is missing.

Filled-in points are hidden, as in a file that leaves such cells empty, and frames that show nothing else are left out.

Legend: F frames, M markers.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from serpenoid.measure.cells import Floats
from serpenoid.measure.film.quality import stretches
from serpenoid.measure.tracks import Tracks

FALSE = 0.03  # of the points that are hidden: stated
LONGEST = 32  # frames: a stretch that needs more to stand out is not told from a slow motion
SINGLE = float(np.finfo(np.float32).eps)
SAME = 1e-9  # of the largest number: values that differ by less are one that was scaled
MISSING = 1.5  # times the usual time from frame to frame, and more: one is missing between
WINDOWS = 20  # of five frames that nobody filled in: they tell how points scatter
FOURTH = 0.6745 * 70**0.5  # median size of fourth differences of white noise, over its SD
SECOND = 0.6745 * 6**0.5  # the same of second differences


def without_filled_in(tracks: Tracks) -> tuple[Tracks, str]:
    """Tracks whose filled-in points are hidden, and what is said of them; else ''."""
    made = _filled_in(tracks)
    if not made.any():
        return tracks, ""
    hidden = made & tracks.seen
    gone = hidden.any(axis=1) & (hidden == tracks.seen).all(axis=1)
    frames = f", in {gone.sum()} of {len(gone)} frames all" if gone.any() else ""
    return tracks.without(hidden).of_frames(~gone), (
        f"{hidden.sum() / tracks.seen.sum():.1%} of its points are on straight lines between frames, to the last "
        f"digit{frames}: filled in by a program, not seen. They are hidden; leave such cells empty in the file"
    )


def _filled_in(tracks: Tracks) -> NDArray[np.bool_]:
    """Which points (F, M) are."""
    floor, found = tracks.floor, np.zeros(tracks.seen.shape, dtype=bool)
    if len(floor) < 3:
        return found
    r, after, steps = rounded_by(floor), np.diff(floor, axis=0), np.diff(tracks.time_s)
    there = steps < MISSING * np.median(steps)
    ways = np.ones(len(steps) - 1), steps[1:] / steps[:-1]
    seconds = [np.abs(after[1:] - h[:, None, None] * after[:-1]).max(axis=2) for h in ways]
    time, away = max(enumerate(seconds), key=lambda way: (way[1] <= r).sum())
    away[~(there[1:] & there[:-1])] = np.nan
    moves = np.abs(after).max(axis=2) > r
    straight = moves[1:] & moves[:-1] & (away <= 2 * r)
    at = tracks.time_s if time else np.arange(float(len(floor)))
    lasts = _on_chords(floor, at, _between_kinks(straight, away > 2 * r), r)
    if _scatter(floor, away, lasts > 0) <= r / 2:
        return found
    for least in range(1, LONGEST + 1):
        lines = (lasts >= least) & (away <= r)
        if (1 + ((lasts >= least) & (away > r)).sum()) / 3 <= FALSE * lines.sum():
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


def _on_chords(floor: Floats, at: Floats, lasts: NDArray[np.int64], r: float) -> NDArray[np.int64]:
    """Lengths of stretches (F - 2, M), 0 where a point (F, M, 2) of one is farther than r from its chord; at (F,): by
    what points go along it."""
    found = lasts.copy()
    for k, column in enumerate(lasts.T):
        for first, last in stretches(column > 0):
            points, along = floor[first : last + 2, k], at[first : last + 2]
            share = ((along - along[0]) / (along[-1] - along[0]))[:, None]
            if np.abs(points - points[0] - share * (points[-1] - points[0])).max() > r:
                found[first:last, k] = 0
    return found


def _scatter(floor: Floats, away: Floats, lines: NDArray[np.bool_]) -> float:
    """SD of single points (F, M, 2), by fourth differences of five frames that are on no lines (F - 2, M); where there
    are few, as of a film that was put on more frames, by second differences (F - 2, M) that are on none."""
    fourth = np.abs(np.diff(floor, n=4, axis=0)).max(axis=2)
    clear = np.isfinite(fourth) & ~(lines[2:] | lines[1:-1] | lines[:-2])
    if clear.sum() >= WINDOWS:
        return float(np.median(fourth[clear])) / FOURTH
    kinks = away[np.isfinite(away) & ~lines]
    return float(np.median(kinks)) / SECOND if len(kinks) else 0.0


def rounded_by(points: Floats) -> float:
    """What second differences of points (..., 2) on a line may be from rounding: two steps of the grid that values of
    either axis are on, in whatever unit it was one; four of numbers of 32 bits at least."""
    largest = float(np.nanmax(np.abs(points), initial=0.0))
    steps = []
    for axis in (0, 1):
        apart = np.diff(np.unique(points[..., axis][np.isfinite(points[..., axis])]))
        apart = apart[apart > SAME * largest]
        steps.append(float(apart.min()) if len(apart) else 0.0)
    return max(2 * min(steps), 4 * SINGLE * largest)
