"""Placeholders: exact points, mostly (0, 0) or (-1, -1), by which some trackers write that they did not see a marker.

A body may pass through a point, rest or begin there; it does not leap there and back. A visit counts as `not seen`
where the marker comes from farther away, and goes farther away, than FAR of its own longest usual step between frames.
Where that happens more than once in a recording at one exact point, or for LONG frames, all that is at it is hidden; at
another point than (0, 0) if most visits are such: markers that are exchanged leap to where another one rests. Where a
film begins or ends at one, nothing tells from where the marker came: there it is (0, 0), a point at which several
markers are at once, which those of a body are not, or one at which it stands for LONG frames while most others move.

Legend: F frames, M markers.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from serpenoid.errors import InputError
from serpenoid.measure.cells import Floats
from serpenoid.measure.film.quality import stretches
from serpenoid.measure.tracks import Tracks
from serpenoid.wording import counted, some_and_more

FAR = 3.0
LONG = 8  # frames: as long as what is told of a marker that stands
USUAL = 0.98  # share of a point's steps: the others are a tracker's leaps
NAMED = 3  # points at most
TRIED = 8  # points that are entered most often: a file has one placeholder, seldom two


def without_placeholders(tracks: Tracks) -> tuple[Tracks, str]:
    """Tracks whose markers at placeholders are hidden, and which these were; else ''."""
    _refuse_one_point(tracks)
    words = []
    for place in _entered(tracks.floor):
        there = (tracks.floor == place).all(axis=2)
        leaps = [
            last - first
            for k in np.flatnonzero(there.any(axis=0)).tolist()
            for first, last in _leaps(tracks.floor, there, k, place)
            if not _exchanged(tracks.floor, k, first, last)
        ]
        visits = sum(len(stretches(column)) for column in there.T)
        most = len(leaps) > visits / 2 or not place.any()
        if most and (len(leaps) > 1 or max(leaps, default=0) >= LONG):
            words.append(_said(there, tracks, place))
            tracks = tracks.without(there)
    return tracks, "; ".join(words)


def _refuse_one_point(tracks: Tracks) -> None:
    """InputError where there is nothing but a placeholder."""
    shown = tracks.floor[tracks.seen]
    if tracks.seen.any(axis=0).sum() > 1 and (shown == shown[:1]).all():
        x, y = shown[0] + 0.0  # no -0
        raise InputError(
            f"{tracks.source}: every marker is at one point, ({x:g}, {y:g}), in every frame. Did the tracker find "
            "nothing, or is it an export of something else?"
        )


def _entered(floor: Floats) -> Iterator[Floats]:
    """Exact points (2,) that markers come to more than once, or are at for LONG frames: (0, 0), then the most usual."""
    seen = np.isfinite(floor).all(axis=2)
    yield np.zeros(2)
    came = np.ones(seen.shape, dtype=bool)
    came[1:] = (floor[1:] != floor[:-1]).any(axis=2)
    points = np.ascontiguousarray(floor[seen]) + 0.0  # -0.0 is 0.0
    places, which, frames = np.unique(points.view(complex)[:, 0], return_inverse=True, return_counts=True)
    entries = np.bincount(which, weights=came[seen])
    often = [i for i in np.argsort(-entries, kind="stable")[:TRIED] if entries[i] > 1]
    long = [i for i in np.argsort(-frames, kind="stable")[:TRIED] if frames[i] >= LONG]
    for i in dict.fromkeys([*often, *long]):
        if places[i] != 0:
            yield np.array([places[i].real, places[i].imag])


def _leaps(floor: Floats, all_there: NDArray[np.bool_], k: int, place: Floats) -> list[tuple[int, int]]:
    """Stretches of frames in which marker k of all (F, M, 2) is at a place, as others (F, M) may be, and was not on its
    way there."""
    path, there = floor[:, k], all_there[:, k]
    seen = np.flatnonzero(np.isfinite(path[:, 0]) & ~there)
    if not there.any() or not len(seen):
        return []
    steps = np.linalg.norm(np.diff(path[seen], axis=0), axis=1) / np.diff(seen)  # a frame
    moving = steps[steps > 0]
    longest = FAR * float(np.quantile(moving, USUAL)) if len(moving) else 0.0

    def surely(first: int, last: int) -> bool:
        shared = all_there[first:last].sum(axis=1).max() > 1
        alone = last - first >= LONG and _others_move(np.delete(floor[first:last], k, axis=1))
        return bool(not place.any() or shared or alone)

    return [
        (first, last)
        for first, last in stretches(there)
        if _away(path - place, seen, first, last, surely(first, last)) > longest
    ]


def _others_move(points: Floats) -> bool:
    """Whether most of other markers (F, M, 2) that are seen are elsewhere from frame to frame, mostly."""
    changes = np.linalg.norm(np.diff(points, axis=0), axis=2)
    seen = np.isfinite(changes)
    return bool((changes[seen] > 0).sum() > seen.sum() / 2)


def _exchanged(floor: Floats, k: int, first: int, last: int) -> bool:
    """Whether another marker is then where this one was before, or where it is afterwards."""
    pairs = [(first - 1, first)] * (first > 0) + [(last, last - 1)] * (last < len(floor))
    return any((np.delete(floor[now], k, axis=0) == floor[then, k]).all(axis=1).any() for then, now in pairs)


def _away(path: Floats, seen: NDArray[np.int64], first: int, last: int, surely: bool) -> float:
    """How far a marker comes and goes, a frame, between a placeholder, seen from which its path (F, 2) is, and the
    nearest frame that shows it: the less; surely: one way is enough, where a film begins or ends there."""
    at = int(np.searchsorted(seen, first))
    beside = [(seen[i], abs(seen[i] - frame)) for i, frame in ((at - 1, first), (at, last - 1)) if 0 <= i < len(seen)]
    if len(beside) < 2 and not surely:
        return 0.0
    return min(float(np.linalg.norm(path[k])) / apart for k, apart in beside)


def _said(there: NDArray[np.bool_], tracks: Tracks, place: Floats) -> str:
    names, unit = tracks.names, "m" if tracks.scale_known else "px"
    at = f"({place[0]:.6g}, {place[1]:.6g})" + (f" {unit}" if place.any() else "")
    counts = there.sum(axis=0)
    which = np.flatnonzero(counts)
    shown = some_and_more([f"`{names[k]}` in {counted(counts[k], 'frame')}" for k in which.tolist()], NAMED)
    return (
        f"{there.mean():.1%} of its points are at exactly {at}, where no marker leaps to and back: {shown}. "
        "Taken for not seen, and hidden; leave such cells empty in the file"
    )
