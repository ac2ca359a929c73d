"""The foam mats: grip that varies a little from place to place, slippery patches, and pulls on single links."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from serpenoid.arena.assembly import Assembly, Pull
from serpenoid.body import Floats

WAVES = 8
SHORTEST_M, LONGEST_M = 0.15, 1.2  # a mat's texture, the size of a mat
RIM_M = 0.01  # over which a patch's edge fades


@dataclass(frozen=True)
class Mats:
    """ln grip = sum of plane waves + trial offset; `waves`: (8, 2) [rad/m], `phases`: (8,), `amplitude`: ln units."""

    waves: Floats
    phases: Floats
    amplitude: float
    offset: float

    @classmethod
    def laid(cls, seed: int, variation: float, offset: float) -> Mats:
        """The same mats for one seed; `variation` is the SD of ln grip over the floor."""
        random = np.random.default_rng([seed, 1])
        lengths = np.exp(random.uniform(np.log(SHORTEST_M), np.log(LONGEST_M), WAVES))
        angles = random.uniform(0, 2 * np.pi, WAVES)
        waves = (2 * np.pi / lengths)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
        return cls(waves, random.uniform(0, 2 * np.pi, WAVES), variation * np.sqrt(2 / WAVES), offset)

    @classmethod
    def even(cls) -> Mats:
        """A floor that is the same everywhere."""
        return cls(np.zeros((1, 2)), np.zeros(1), 0.0, 0.0)

    def factor(self, places: Floats) -> Floats:
        """Factor on the friction coefficient at floor points, shape (n, 2) -> (n,)."""
        return np.exp(self.offset + self.amplitude * np.cos(places @ self.waves.T + self.phases).sum(axis=1))


def patch_factor(assembly: Assembly, places: Floats) -> Floats:
    """Product of the patches' factors at floor points, shape (n, 2) -> (n,)."""
    factor = np.ones(len(places))
    for patch in assembly.patches:
        distance = np.hypot(places[:, 0] - patch.x_m, places[:, 1] - patch.y_m)
        inside = 0.5 * (1 + np.tanh((patch.radius_m - distance) / RIM_M))
        factor *= patch.factor**inside
    return factor


def force(pull: Pull, place: Floats, time_s: float) -> Floats:
    """Horizontal force [N] of one pull on a link at `place` (2,)."""
    if pull.kind == "gust":
        force_x, force_y, begin, duration = pull.values
        return np.array([force_x, force_y]) * (begin <= time_s < begin + duration)
    x, y, strength, reach = pull.values
    towards = np.array([x, y]) - place
    distance = float(np.hypot(*towards)) + 1e-9
    if pull.kind == "magnet":
        return strength * towards / distance / (1 + (distance / reach) ** 2) ** 2
    return strength * max(0.0, distance - reach) * towards / distance  # tether: slack up to its length
