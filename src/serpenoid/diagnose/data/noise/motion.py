"""What the stage of motion has to go by: tracks, the noise of their windows, what is known beforehand."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.noise.memory import Memory
from serpenoid.diagnose.data.noise.repeats import chance_from
from serpenoid.diagnose.data.noise.white import White
from serpenoid.diagnose.data.windows.windows import Track
from serpenoid.effects.active import ActiveEffect, of_key


@dataclass(frozen=True)
class Noise:
    """Standard deviations [m, m, rad] of a window's displacement while playing (3,) and in pauses (3,).

    by_setting: of trials of one setting, while playing, where their repeats tell. memory: how long chance lasts.
    """

    playing: Floats
    pause: Floats
    by_setting: Mapping[tuple[str, float], Floats] = field(default_factory=dict)
    memory: Memory = field(default_factory=Memory)

    def chance(self, track: Track) -> Floats:
        """(B - 1, 3); no less than the markers' own noise."""
        if track.noise is not None:
            return track.noise.copy()
        playing = self.by_setting.get(track.recording.setting, self.playing)
        return np.maximum(np.where(track.playing[:, None], playing, self.pause), track.least)

    def of(self, track: Track) -> Floats:
        """(B - 1, 3), with what the baseline itself is in doubt about."""
        return np.hypot(self.chance(track), track.doubt)


# of settings: how far apart paths of repeats are, RMS [m] over sqrt 2, and of how many pairs
Apart = tuple[tuple[tuple[str, float], float, int], ...]


class Repeated(NamedTuple):
    """How far apart paths of repeats are, over what the noise of their windows adds up to, squared; how many pairs tell
    that; how many numbers their windows are worth (`Memory.scattered`); the same in metres, by settings."""

    square: float = 1.0
    pairs: int = 0
    scattered: tuple[float, ...] = ()
    apart: Apart = ()

    def beside(self, other: Repeated) -> Repeated:
        """Told by both."""
        pairs = self.pairs + other.pairs
        square = (self.pairs * self.square + other.pairs * other.square) / max(pairs, 1)
        return self._replace(square=square, pairs=pairs) if pairs else self


@dataclass(frozen=True)
class Motion:
    """The tracks and their noise; labels: gait numbers, one per track; held: known effects, not up for fitting.

    unlike (3,): the largest difference between two repeats' windows that is no news [m, m, rad]. untestable: effects
    that are no candidates. ratio: eps of an earlier campaign; ratio_held: it is taken to be the same, and no fit moves
    it. earlier: what repeats of an earlier campaign tell.
    """

    tracks: tuple[Track, ...]
    noise: Noise
    labels: tuple[int, ...]
    held: tuple[ActiveEffect, ...] = ()
    unlike: Floats | float = 0.0
    untestable: frozenset[str] = frozenset()
    ratio: float | None = None
    earlier: Repeated = Repeated()
    ratio_held: bool = False

    @cached_property
    def white(self) -> tuple[White, ...]:
        """What makes values of each track's windows white."""
        repeats = Counter(t.recording.setting for t in self.tracks)
        return tuple(
            White(t, self.noise.chance(t), self.noise.memory, repeats=repeats[t.recording.setting]) for t in self.tracks
        )

    def unchanged(self, effect: ActiveEffect) -> list[float]:
        """Coordinates of an effect where nothing has changed (P,): those that it is held at, or neutral ones."""
        known = of_key(self.held, effect.key)
        return [p.resting for p in effect.effect.parameters] if known is None else known.coordinates[:-1]

    @property
    def unrepeated(self) -> bool:
        """Whether noise is what a model leaves, for want of anything that was played again."""
        return chance_from(self.tracks) == "residuals"
