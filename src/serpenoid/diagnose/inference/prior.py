"""Priors: every coordinate about the value that changes nothing, eps about what bodies are known to have.

    p(x) = mean over w of N(x; neutral, (w typical)^2),  w in 1, 4, 16        (of eps: of its logarithm)

Heavy tails: one width would forbid what is strong or favour what is weak. What has no neutral value says where a patch
lies, typically on the floor that was visited, and how wide it is: a quarter of the body's length, of its logarithm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.motion import Motion
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import Parameter

WIDTHS = np.array([1.0, 4.0, 16.0])
EPS, EPS_WIDTH = 0.2, 0.5  # wheels, bellies, fins: 0.07 to 0.55 within two SD of the narrowest part
KNOWN_WIDTH = 0.02  # of ln eps from one day to the next, where it was measured before
SIZE, SIZE_WIDTH = (
    0.25,
    0.7,
)  # body lengths; of its logarithm: a factor of four either way within two SD of the narrowest


@dataclass(frozen=True)
class Floor:
    """Where bodies were: middle (2,), SD (2,) of a place that may lie anywhere there, their length [m]."""

    middle: Floats
    width: Floats
    length: float

    @classmethod
    def of(cls, motion: Motion) -> Floor:
        """A rectangle about all poses, half a body length wider; of an even density the SD is a width over sqrt 12."""
        length = motion.tracks[0].recording.body.total_length_m
        places = np.concatenate([t.poses[:, :2] for t in motion.tracks])
        low, high = places.min(axis=0) - length / 2, places.max(axis=0) + length / 2
        return cls((low + high) / 2, (high - low) / np.sqrt(12), length)


@dataclass(frozen=True)
class Prior:
    """Of coordinates (P,), eps first, then the effects'; logarithmic (P,): whether the logarithm counts."""

    middle: Floats
    width: Floats
    logarithmic: Floats

    @classmethod
    def of(cls, motion: Motion, effects: Sequence[ActiveEffect]) -> Prior:
        """eps is known where it was measured before."""
        eps = (np.log(EPS), EPS_WIDTH) if motion.ratio is None else (np.log(motion.ratio), KNOWN_WIDTH)
        found = [(eps[0], eps[1], True)]
        floor = Floor.of(motion) if any(_unplaced(p) for e in effects for p in e.effect.parameters) else None
        for e in effects:
            axes = iter(range(2))
            for p in e.effect.parameters:
                if not _unplaced(p) or floor is None:
                    width = abs(p.coordinate(p.typical) - p.resting)
                    found.append((p.resting, width, False))
                elif p.lower > 0:
                    found.append((np.log(SIZE * floor.length), SIZE_WIDTH, True))
                else:
                    axis = next(axes)
                    found.append((floor.middle[axis], floor.width[axis], False))
        return cls(*(np.array(column) for column in zip(*found, strict=True)))

    def stretch(self, x: Floats) -> Floats:
        """Of coordinates x, by what counts (P,): dx / d ln x where logarithms do."""
        return np.where(self.logarithmic, x, 1.0)

    def widest(self, x: Floats) -> Floats:
        """Width (P,) of the widest part of the mixture, in the coordinates about x."""
        return np.asarray(WIDTHS.max() * self.width * self.stretch(x))

    def _shares(self, x: Floats) -> tuple[Floats, Floats]:
        """Distance from the middle in widths (P,), log densities of each part of the mixture (3, P)."""
        away = np.where(self.logarithmic, np.log(self.stretch(x)), x) - self.middle
        away, spread = away / self.width, WIDTHS[:, None]
        return away, -0.5 * (away / spread) ** 2 - np.log(spread * self.width) - 0.5 * np.log(2 * np.pi)

    def log_density(self, x: Floats) -> float:
        """ln p, summed; per unit of a logarithm where these count."""
        _, parts = self._shares(x)
        most = parts.max(axis=0)
        return float((most + np.log(np.exp(parts - most).mean(axis=0))).sum())

    def pull(self, x: Floats) -> tuple[Floats, Floats]:
        """-d ln p / dx and its positive curvature (P,)."""
        away, parts = self._shares(x)
        share = np.exp(parts - parts.max(axis=0))
        share /= share.sum(axis=0)
        precision = (share / WIDTHS[:, None] ** 2).sum(axis=0) / self.width**2
        chain = self.stretch(x)
        return precision * away * self.width / chain, precision / chain**2


def _unplaced(p: Parameter) -> bool:
    return p.neutral is None
