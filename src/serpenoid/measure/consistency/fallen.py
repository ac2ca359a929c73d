"""Markers that fell off: from some moment to the end of the film one lies still while the body goes on without it.

From frame f on marker k stays where it is at the end, within `STILL` of an edge or its noise, while the middle one of
the others (median) goes on by more than that; and its distance to a neighbour, steady before, is wrong by more than
`LEFT` of it at the end. A body that comes to rest takes all its links with it.

Legend: F frames, N markers of a chain of rigid links, tail first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from serpenoid.measure.cells import Floats, clock
from serpenoid.measure.consistency.signals import LEAST_ROWS, Signal

STILL = 0.1  # of the median distance between neighbours: a marker that lies on the floor may be touched
NOISE = 5.0  # standard deviations of a marker's noise, which it stays within
LEFT = 0.2  # of a link's length: no marker is so far beside its place for a part of a film


@dataclass(frozen=True)
class Fallen:
    """Which marker lies still from a frame on, and by what share its distance to a neighbour is wrong at the end."""

    marker: int
    frame: int
    away: float

    def words(self, name: str, time_s: Floats) -> str:
        """What is seen, without its witness."""
        return (
            f"`{name}` lies still from {clock(time_s[self.frame])} s on while the others go on, and its distance to a "
            f"neighbour is wrong by {self.away:.0%} at the end"
        )


def fallen(points: Floats) -> tuple[Fallen, ...]:
    """Of markers (F, N, 2), NaN hidden."""
    distance = np.linalg.norm(np.diff(points, axis=1), axis=2)
    if points.shape[1] < 3 or not np.isfinite(distance).any():
        return ()
    link = STILL * float(np.nanmedian(distance))
    found = []
    for k in range(points.shape[1]):
        seen = np.flatnonzero(np.isfinite(points[:, k, 0]))
        if len(seen) < 2 * LEAST_ROWS:
            continue
        noise = Signal(np.arange(len(points), dtype=float), points[:, k]).noise_variance.max()
        still = float(np.hypot(link, NOISE * np.sqrt(noise)))
        lies = np.median(points[seen[-LEAST_ROWS:], k], axis=0)
        moved = np.flatnonzero(np.linalg.norm(points[seen, k] - lies, axis=1) > still)
        first = int(seen[moved[-1] + 1]) if len(moved) and moved[-1] + 1 < len(seen) else None
        if first is None or np.isin(seen, range(first, len(points))).sum() < LEAST_ROWS:
            continue
        others = np.delete(points, k, axis=1)
        if _gone_on(others[first:]) > 2 * still and (away := _away(distance, k, first)) > LEFT:
            found.append(Fallen(k, first, away))
    return tuple(found)


def _gone_on(points: Floats) -> float:
    """How far the middle one of some markers (F, M, 2) is at the end from where it was at the beginning."""
    parts = points[:LEAST_ROWS], points[-LEAST_ROWS:]
    both = np.all([np.isfinite(part[..., 0]).any(axis=0) for part in parts], axis=0)
    if not both.any():
        return 0.0
    begin, end = (np.nanmedian(part[:, both], axis=0) for part in parts)
    return float(np.median(np.linalg.norm(end - begin, axis=1)))


def _away(distance: Floats, k: int, first: int) -> float:
    """By what share the distance (F, N - 1) of marker k to a neighbour, steady before, is wrong at the end, at most."""
    worst = 0.0
    for edge in {k - 1, k} & set(range(distance.shape[1])):
        before, end = distance[:first, edge], distance[-LEAST_ROWS:, edge]
        if np.isfinite(before).any() and np.isfinite(end).any():
            usual = float(np.nanmedian(before))
            steady = float(np.nanmedian(np.abs(before - usual))) < STILL * usual
            worst = max(worst, abs(float(np.nanmedian(end)) / usual - 1)) if steady else worst
    return worst
