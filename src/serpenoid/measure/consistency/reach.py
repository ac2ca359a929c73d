"""How far apart a body allows its markers to be.

Two markers of one link are as far apart as that link's edges are long. Of two with joints between them it allows all
from what is left where the body folds to what it is where it is straight:

    max(0, 2 longest - sum) .. sum        of the stretches between joints: of one stretch both are its length

An animal's links are arcs: two of its points on one show the chord, others anything up to their arc.
Legend: F frames, N vertices, M markers, tail first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from serpenoid.body import Body
from serpenoid.measure.cells import Floats
from serpenoid.measure.shapes.lengths import chord_shares


@dataclass(frozen=True)
class Reach:
    """Least and largest distances (M - 1,) between successive markers that a body allows; one number on one link."""

    low: Floats
    high: Floats

    @property
    def rigid(self) -> np.ndarray:
        """Where both are on one link (M - 1,)."""
        return np.asarray(self.low == self.high)

    def nearest(self, distance: Floats) -> Floats:
        """What the body allows that is nearest to distances (..., M - 1)."""
        return np.clip(distance, self.low, self.high)

    def with_length(self, pair: int, distance: float) -> Reach:
        """The same with another distance between the two of a pair on one link."""
        low, high = self.low.copy(), self.high.copy()
        low[pair] = high[pair] = distance
        return Reach(low, high)


def reach(body: Body, edges: Floats, vertices: Floats, shown: Sequence[int]) -> Reach:
    """Of the markers of some vertices: edges (N - 1,) in the unit of `vertices` (F, N, 2)."""
    along = np.concatenate([[0.0], np.cumsum(edges)])
    parts = [np.diff(along[[a, *(j for j in body.joint_vertices if a < j < b), b]]) for a, b in pairwise(shown)]
    high = np.array([part.sum() for part in parts])
    low = np.array([max(0.0, 2 * part.max() - part.sum()) for part in parts])
    if body.is_animal:
        one = np.array([len(part) == 1 for part in parts], dtype=bool)
        high = np.where(one, high * np.median(chord_shares(body, vertices, shown), axis=0), high)
        low = np.where(one, high, 0.0)
    return Reach(low, high)
