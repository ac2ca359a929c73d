"""Points whose names a tracker exchanges for a part of a recording: a point goes on as it went.

    log evidence of names p at a cut = - sum_k [ 3/2 log(1 + |ahead_p(k) - behind_k|^2 / s^2) + 2 log s ]     (Cauchy)

behind, ahead: where the frames before and after the cut, each alone, put a point half-way between. s: what nine
mismatches in ten stay within, for as long as the point was not seen; more in a frame in which all points are quick. Any
permutation may begin at any frame: two points, three in a ring; it is one of as many as there are of so many points.
Head for tail is one by itself: trackers of bodies without marks confuse the ends, some of them so often that no s is
left (`often_reversed`). Names that lead by `ODDS` change there; what they are for most of the recording is right.
Legend: F frames, N points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

from serpenoid.measure.cells import Floats, clock, listed
from serpenoid.measure.consistency.layout import middles
from serpenoid.measure.consistency.often_reversed import often_reversed
from serpenoid.measure.consistency.rivals import ODDS

SHARE = 0.9  # of all mismatches are within s: of a body that rests half the time, those that move
REFUTED = 0.5  # names that are there, which leave distances of neighbours so much less off, were not exchanged
MOST_TOLD = 3  # parts of one recording, the longest
TAIL = 1.5  # exponent of a Cauchy distribution in the plane
Names = tuple[int, ...]


@dataclass(frozen=True)
class Exchange:
    """For frames first..last (inclusive) point `k` has the name `names[k]`; `gain`: its lead [nats]."""

    first: int
    last: int
    names: Names
    gain: float

    def said(self, labels: Sequence[str], time_s: Floats) -> str:
        """Which points, from when to when on the recording's clock."""
        changed = [k for k, name in enumerate(self.names) if name != k]
        mirrored = list(self.names) == list(range(len(self.names)))[::-1] and len(changed) > 3
        which = "all points, head for tail," if mirrored else listed([f"`{labels[k]}`" for k in changed])
        first, last = clock(time_s[self.first]), clock(time_s[self.last])
        return (
            f"{which} exchanged at {first} s"
            if self.first == self.last
            else f"{which} exchanged between {first} and {last} s"
        )


@dataclass(frozen=True)
class Change:
    """Before `frame` point `k` had the name that `names[k]` has from there on; its points are seen before `since_s` and
    after `until_s`."""

    frame: int
    names: Names
    gain: float
    since_s: float
    until_s: float


def exchanges(points: Floats, time_s: Floats, odds: float = ODDS) -> tuple[Exchange, ...]:
    """Parts of a recording (F, N, 2) in which points have other names than in most of it; odds: asked of a change."""
    turned, gain = often_reversed(points)
    if gain > odds:
        return _reversed_parts(turned, points.shape[1], gain)
    changes = _certain(_changes(points, time_s), odds) if len(time_s) > 2 else []
    while changes:
        found = _parts(changes, points)
        refuted = next((one for one in found if _refuted(one, points, found)), None)
        if refuted is None:
            return found
        ends = [change for change in changes if change.frame in (refuted.first, refuted.last + 1)]
        changes.remove(min(ends, key=lambda change: change.gain))
    return ()


def _reversed_parts(turned: NDArray[np.bool_], count: int, gain: float) -> tuple[Exchange, ...]:
    """Runs of frames (F,) whose points are named from the other end."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], turned, [False]])))
    ends = zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    return tuple(Exchange(first, stop - 1, tuple(range(count))[::-1], gain) for first, stop in ends)


def _parts(changes: Sequence[Change], points: Floats) -> tuple[Exchange, ...]:
    """What the changes make of a recording."""
    starts = [0, *(change.frame for change in changes), len(points)]
    held: list[Names] = [tuple(range(points.shape[1]))]
    for change in changes:
        held.append(tuple(held[-1][k] for k in change.names))
    lasted: dict[Names, int] = {}
    for names, first, end in zip(held, starts[:-1], starts[1:], strict=True):
        lasted[names] = lasted.get(names, 0) + end - first
    right = max(lasted, key=lambda names: lasted[names])
    return tuple(
        Exchange(first, end - 1, _relative(names, right), max(change.gain for change in changes[max(i - 1, 0) : i + 1]))
        for i, (names, first, end) in enumerate(zip(held, starts[:-1], starts[1:], strict=True))
        if names != right
    )


def _refuted(one: Exchange, points: Floats, found: Sequence[Exchange]) -> bool:
    """Whether neighbours are clearly nearer to their usual distances with the names that are there: two points that
    strayed to one place in turn, as to a reflection, went on as if exchanged, and came back each for itself."""
    part = points[one.first : one.last + 1]
    put = part.copy()
    put[:, list(one.names)] = part
    others = np.ones(len(points), bool)
    for exchange in found:
        others[exchange.first : exchange.last + 1] = False
    usual = middles(_apart(points[others]))
    there, instead = (middles(np.abs(_apart(named) - usual)) for named in (part, put))
    known = np.isfinite(there) & np.isfinite(instead)
    return bool(there[known].max(initial=0.0) < REFUTED * instead[known].max(initial=0.0))


def _apart(points: Floats) -> Floats:
    """Distances of neighbours (F, N - 1)."""
    return np.asarray(np.linalg.norm(np.diff(points, axis=1), axis=2))


def named_as_in_most(points: Floats, time_s: Floats) -> tuple[Floats, tuple[Exchange, ...]]:
    """Points (F, N, 2) with the names that they have for most of the recording, and what was exchanged for it."""
    found = exchanges(points, time_s)
    put = points.copy()
    for one in found:
        part = slice(one.first, one.last + 1)
        put[part][:, list(one.names)] = points[part]
    return put, found


def told(found: Sequence[Exchange], labels: Sequence[str], time_s: Floats) -> str:
    """The longest of them in order of time, and how many more there are."""
    longest = sorted(sorted(found, key=lambda one: one.first - one.last)[:MOST_TOLD], key=lambda one: one.first)
    more = f", and in {len(found) - MOST_TOLD} more parts" if len(found) > MOST_TOLD else ""
    return f"{'; '.join(one.said(labels, time_s) for one in longest)}{more}"


def _certain(changes: list[Change], odds: float) -> list[Change]:
    """Those that lead by `odds`, and likelier ones next to them that undo them."""
    own = tuple(range(len(changes[0].names))) if changes else ()
    kept = []
    for i, change in enumerate(changes):
        beside = [*changes[max(i - 1, 0) : i], *changes[i + 1 : i + 2]]
        undone = [b for b in beside if b.gain > odds and tuple(b.names[k] for k in change.names) == own]
        if change.gain > odds or undone:
            kept.append(change)
    return kept


def _relative(names: Names, right: Names) -> Names:
    """Which point of the right names each one is."""
    return tuple(right.index(name) for name in names)


def _changes(points: Floats, time_s: Floats) -> list[Change]:
    """Wherever names are likelier to change, in order of time."""
    cut = _Cuts.of(points, time_s)
    own = np.linalg.norm(cut.ahead - cut.behind, axis=2) / (cut.first_s - cut.last_s)
    usual = float(np.nanquantile(own, SHARE)) if np.isfinite(own).any() else 0.0
    if not usual > 0:
        return []
    found: list[Change] = []
    for frame in _odd(cut):
        change = _change(cut, int(frame), usual)
        if change is None:
            continue
        if found and change.since_s < found[-1].until_s:  # the same, while its points are hidden
            change = max(found.pop(), change, key=lambda one: one.gain)
        found.append(change)
    return found


def _change(cut: _Cuts, frame: int, usual: float) -> Change | None:
    from scipy.optimize import linear_sum_assignment  # where every point goes on as it went, nobody waits for it

    here = np.flatnonzero(np.isfinite(cut.behind[frame, :, 0]) & np.isfinite(cut.ahead[frame, :, 0]))
    moved = cut.ahead[frame, here][:, None] - cut.behind[frame, here][None]  # [k, j]: point k after, j before
    scale = usual * (cut.first_s[frame, here][:, None] - cut.last_s[frame, here][None])
    missed = np.linalg.norm(moved, axis=2) / scale
    rows, order = linear_sum_assignment(np.log1p(missed**2))
    changed = here[rows[order != rows]]
    pushed = np.diagonal(moved).T  # (K, 2): by a camera that is pushed all move alike
    away = np.linalg.norm(pushed - np.median(pushed, axis=0), axis=1) / np.diagonal(scale)
    own = min(_cost(np.diagonal(missed)), _cost(away))
    count = len(cut.behind[0])
    left = _cost(missed[rows, order]) + _ways(len(here), len(changed))
    if np.array_equal(here[::-1], count - 1 - here):  # whatever is seen, seen from either end
        mirrored = _cost(np.diagonal(missed[::-1]))
        if mirrored < left:
            left, order, changed = mirrored, rows[::-1], here[here != here[::-1]]
    left += float(np.log(count))
    if not (len(changed) and own > left):
        return None
    slid = [np.linalg.norm(cut.ahead[frame, here] - to[here], axis=1) for to in _along_itself(cut.behind[frame])]
    gain = min([own, *(_cost(far / np.diagonal(scale)) for far in slid)]) - left
    if not gain > 0:
        return None
    names = np.arange(count)
    names[here[rows]] = here[order]
    since, until = cut.last_s[frame, changed].min(), cut.first_s[frame, changed].max()
    return Change(frame, tuple(names.tolist()), gain, float(since), float(until))


def _along_itself(points: Floats) -> list[Floats]:
    """Where points (N, 2), NaN unknown, are when a body has slid along itself by whole vertices, straight on at its
    ends: of what snakes do no tracker is accused."""
    count = len(points)
    place, known = np.arange(count), np.flatnonzero(np.isfinite(points[:, 0]))
    if len(known) < 2:
        return []
    whole = np.stack([np.interp(place, known, column[known]) for column in points.T], axis=1)
    step = np.arange(1, count)[:, None]
    far = np.concatenate(
        [(whole[0] - step * (whole[1] - whole[0]))[::-1], whole, whole[-1] + step * (whole[-1] - whole[-2])]
    )
    return [far[count - 1 + by : 2 * count - 1 + by] for by in range(-(count // 2), count // 2 + 1) if by]


def _cost(missed: Floats) -> float:
    """Log evidence lost by mismatches (K,) in units of s, by the likeliest common factor of s, 1 or more: a frame in
    which the whole body is quick (rows that are held) is odd once, not once for each of its points."""
    factors = np.append(1.0, missed[missed > 1])[:, None]
    return float((TAIL * np.log1p((missed / factors) ** 2) + 2 * np.log(factors)).sum(axis=1).min())


def _ways(points: int, changed: int) -> float:
    """Log of the number of ways to choose and permute so many of the points."""
    return float(gammaln(points + 1) - gammaln(points - changed + 1))


@dataclass(frozen=True)
class _Cuts:
    """Before every frame: points (F, N, 2) there by the frames before, and by those from there on; when (F, N) each was
    last seen before, and is first seen after. NaN: not."""

    behind: Floats
    ahead: Floats
    last_s: Floats
    first_s: Floats

    @classmethod
    def of(cls, points: Floats, time_s: Floats) -> _Cuts:
        """Cuts lie half-way between frames; the first has nothing before it."""
        cut = np.concatenate([time_s[:1], (time_s[1:] + time_s[:-1]) / 2])[:, None]
        speed = np.diff(points, axis=0) / np.diff(time_s)[:, None, None]
        none = np.full((1, *points.shape[1:]), np.nan)
        after, first_s = _next_seen(points, np.concatenate([speed, none]), time_s)
        before, last_s = _next_seen(points[::-1], np.concatenate([none, speed])[::-1], time_s[::-1])
        before, last_s = (np.concatenate([x[:1] * np.nan, x[::-1][:-1]]) for x in (before, last_s))
        behind, ahead = (
            x[..., :2] + np.nan_to_num(x[..., 2:]) * (cut - at)[..., None]
            for x, at in ((before, last_s), (after, first_s))
        )
        return cls(behind, ahead, last_s, first_s)


def _next_seen(points: Floats, speed: Floats, time_s: Floats) -> tuple[Floats, Floats]:
    """Position and speed (F, N, 4) where each point is seen next, at that frame or after it, and when (F, N)."""
    count = len(points)
    seen = np.isfinite(points[..., 0])
    at = np.minimum.accumulate(np.where(seen, np.arange(count)[:, None], count)[::-1], axis=0)[::-1]
    there, row = at < count, np.minimum(at, count - 1)
    state = np.take_along_axis(np.concatenate([points, speed], axis=2), row[..., None], axis=0)
    return np.where(there[..., None], state, np.nan), np.where(there, time_s[row], np.nan)


def _odd(cut: _Cuts) -> NDArray[np.int64]:
    """Frames (.,) before which a point goes on from where another was rather than from where it was itself."""
    odd = np.zeros(len(cut.behind), dtype=bool)
    (x, y), (from_x, from_y) = (np.moveaxis(ends, 2, 0) for ends in (cut.ahead, cut.behind))
    with np.errstate(invalid="ignore"):
        own = (x - from_x) ** 2 + (y - from_y) ** 2
        for k in range(cut.behind.shape[1]):
            odd |= ((x - from_x[:, k, None]) ** 2 + (y - from_y[:, k, None]) ** 2 < own).any(axis=1)
    return np.flatnonzero(odd)
