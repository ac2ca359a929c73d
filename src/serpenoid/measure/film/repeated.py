"""Repeated frames: pictures that a camera or a program put in twice, to be at a rate at which they were not taken.

A frame repeats the one before if the same points are seen in it, FEWEST or more, all to the last digit where they were.
A body that rests may do so, too, as far as its file rounds. So a film has such frames where more than half of these
stretches are amid motion: up to LONGEST frames, between steps of at least HALF the usual one, before and after, where
the usual step of the usual point is more than FAR times what rounding makes. A body that is still between two such
steps has neither slowed down nor begun to move. Then all stretches no longer than these are told. Where all points then
leap, a camera hung (`consistency.frozen`). Once or twice is chance.

Legend: F frames, M markers.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from serpenoid.measure.cells import Floats
from serpenoid.measure.film.filled_in import rounded_by
from serpenoid.measure.film.quality import stretches
from serpenoid.measure.tracks import Tracks

FEWEST = 3  # points
LONGEST = 8  # frames: more is a rest, or a camera that hung
HALF = 0.5
FAR = 1.0  # times what rounding makes, two steps of the file
LEAP = 3.0  # times the usual step
CHANCE = 2  # stretches


def without_repeated(tracks: Tracks) -> tuple[Tracks, str]:
    """Tracks without frames that repeat the one before, and what is said of them; else ''."""
    again = _repeated(tracks.floor)
    if not again.any():
        return tracks, ""
    return tracks.of_frames(~again), (
        f"{again.sum()} of its {len(again)} frames show every point where the frame before does, to the last digit, "
        "amid motion: pictures that are there twice, in a film of another rate. They are left out, and the others keep "
        "their times"
    )


def _repeated(floor: Floats) -> NDArray[np.bool_]:
    """Which frames (F,) are."""
    found = np.zeros(len(floor), dtype=bool)
    if len(floor) < 3:
        return found
    seen = np.asarray(np.isfinite(floor).all(axis=2))
    steps = np.abs(np.diff(floor, axis=0)).max(axis=2)
    both = seen[1:] & seen[:-1]
    still = ((steps == 0) | ~both).all(axis=1)
    same = np.asarray(still & (seen[1:] == seen[:-1]).all(axis=1) & (both.sum(axis=1) >= FEWEST))
    if not same.any():
        return found
    usual = np.array([np.median(row[there]) if there.any() else 0.0 for row, there in zip(steps, both, strict=True)])
    moving = usual[usual > 0]
    size = float(np.median(moving)) if len(moving) else 0.0
    runs = stretches(same)
    told = [run for run in runs if run[1] - run[0] <= LONGEST and _amid(usual, *run, size)]
    if len(told) <= max(CHANCE, len(runs) / 2) or size <= FAR * rounded_by(floor):
        return found
    longest = max(last - first for first, last in told)
    for first, last in runs:
        found[first + 1 : last + 1] = last - first <= longest
    return found


def _amid(steps: Floats, first: int, last: int, size: float) -> bool:
    """Whether steps (F - 1,) beside some of them are as in motion, of which the usual is `size`."""
    if first == 0 or last == len(steps):
        return False
    return bool(min(steps[first - 1], steps[last]) >= HALF * size and steps[last] <= LEAP * size)
