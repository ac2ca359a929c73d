"""What was played again: a setting in another trial; where no setting was, a cycle by the next one of its trial.

Differences of the two tell chance, and what both share is not chance. Cycles share also what differs from trial to
trial (where the body was laid, how a servo was zeroed): they tell less, and are only used where there is nothing else.

A body laid elsewhere or at another heading feels the room from another side. So trials that were laid alike are
compared; only where none were, are those that were laid otherwise, and then untold.py asks what their differences are.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.windows.windows import Track

UNLIKE = 3.0  # times the earlier largest difference between repeats: a push, not the same chance on another motion
ALIKE = 1 / 3  # of what the room does at most in the difference of two trials that were laid alike


@dataclass(frozen=True)
class Repeat:
    """The same windows of two trials, or of two cycles of one: tracks by number, windows of each (K,)."""

    one: int
    other: int
    here: np.ndarray
    there: np.ndarray

    def both(self, values: Sequence[Floats]) -> tuple[Floats, Floats]:
        """Values (W, 3) of each track, at the windows of the one and of the other (K, 3)."""
        return values[self.one][self.here], values[self.other][self.there]


def repeats(tracks: Sequence[Track]) -> list[Repeat]:
    """Of successive trials of a setting (see `pairs`); if no setting was repeated, of successive cycles."""
    trials = pairs(tracks)
    if not trials:
        return [r for i in range(len(tracks)) for r in cycles(tracks, i)]
    counts = [(a, b, np.arange(min(len(tracks[a].playing), len(tracks[b].playing)))) for a, b in trials]
    return [Repeat(a, b, windows, windows) for a, b, windows in counts]


def pairs(tracks: Sequence[Track]) -> list[tuple[int, int]]:
    """Indices of successive trials of one setting that were laid alike; if none were, of all."""
    return laid_alike(tracks) or _successive(by_setting(tracks).values())


def none_alike(tracks: Sequence[Track]) -> bool:
    """Whether settings were repeated, but never laid alike."""
    return not laid_alike(tracks) and bool(pairs(tracks))


def alike(one: Track, other: Track) -> bool:
    """Whether two trials begin so near to each other that a force or a floor of the room shows no more than ALIKE of
    itself in their difference: a force of one direction by twice the sine of half the angle between their headings, a
    floor that differs over a body length by their distance in body lengths."""
    length = one.recording.body.total_length_m
    (x, y, heading), (u, v, to) = one.on_floor[0], other.on_floor[0]
    return bool(max(abs(2 * np.sin((heading - to) / 2)), np.hypot(x - u, y - v) / length) <= ALIKE)


def laid_alike(tracks: Sequence[Track]) -> list[tuple[int, int]]:
    """Successive trials of a setting that were laid as the first of their group was."""
    groups: list[list[int]] = []
    for same in by_setting(tracks).values():
        own: list[list[int]] = []
        for i in same:
            mine = next((g for g in own if alike(tracks[g[0]], tracks[i])), None)
            if mine is None:
                own.append([i])
            else:
                mine.append(i)
        groups += own
    return _successive(groups)


def _successive(groups: Iterable[Sequence[int]]) -> list[tuple[int, int]]:
    return [pair for same in groups for pair in pairwise(same)]


def by_setting(tracks: Sequence[Track]) -> dict[tuple[str, float], list[int]]:
    """Indices of the trials of each setting."""
    found: dict[tuple[str, float], list[int]] = {}
    for i, t in enumerate(tracks):
        found.setdefault(t.recording.setting, []).append(i)
    return found


def chance_from(tracks: Sequence[Track]) -> str:
    """What tells chance: `points` (tracks bring their own noise), `trials` or `cycles` that were played again, or, for
    want of these, the `residuals`: then noise is all that a model leaves."""
    if any(t.noise is not None for t in tracks):
        return "points"
    if pairs(tracks):
        return "trials"
    return "cycles" if repeats(tracks) else "residuals"


def cycles(tracks: Sequence[Track], number: int) -> list[Repeat]:
    """Each cycle of a track and the next, as far as that was recorded."""
    track, found = tracks[number], []
    for n in np.unique(track.cycle)[:-1]:
        here, there = (np.flatnonzero(track.cycle == cycle) for cycle in (n, n + 1))
        count = min(len(here), len(there))
        found.append(Repeat(number, number, here[:count], there[:count]))
    return found
