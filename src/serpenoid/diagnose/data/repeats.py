"""What was played again: a setting in another trial; where no setting was, a cycle by the next one of its trial.

Differences of the two tell chance, and what both share is not chance. Cycles share also what differs from trial to
trial (where the body was laid, how a servo was zeroed): they tell less, and are only used where there is nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.windows import Track


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
    """Of successive trials of a setting; if no setting was repeated, of successive cycles."""
    trials = pairs(tracks)
    if not trials:
        return [r for i, t in enumerate(tracks) for r in _cycles(i, t)]
    counts = [(a, b, np.arange(min(len(tracks[a].playing), len(tracks[b].playing)))) for a, b in trials]
    return [Repeat(a, b, windows, windows) for a, b, windows in counts]


def pairs(tracks: Sequence[Track]) -> list[tuple[int, int]]:
    """Indices of successive trials of one setting."""
    return [(a, b) for same in by_setting(tracks).values() for a, b in zip(same[:-1], same[1:], strict=True)]


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


def _cycles(number: int, track: Track) -> list[Repeat]:
    """Each cycle and the next, as far as that was recorded."""
    found = []
    for n in np.unique(track.cycle)[:-1]:
        here, there = (np.flatnonzero(track.cycle == cycle) for cycle in (n, n + 1))
        count = min(len(here), len(there))
        found.append(Repeat(number, number, here[:count], there[:count]))
    return found
