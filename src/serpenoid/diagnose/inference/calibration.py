"""What a search finds on nothing: the best gain of log posterior odds on draws of this campaign's own null.

Under the present explanation the vector of every candidate column is normal with its projected matrix as covariance.
All candidates are scored on each draw as they are on the data, and the best is kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.inference.posterior import linear_gain

DRAWS = 400
ERROR = 0.01  # false alarms: stated, for each campaign


@dataclass(frozen=True)
class Candidates:
    """matrix (C, C): projected, of all columns; groups: columns of each candidate; widths, odds: of their priors."""

    matrix: Floats
    groups: tuple[tuple[int, ...], ...]
    widths: tuple[Floats, ...]
    odds: Floats

    def best_on_nothing(self, draws: int = DRAWS) -> Floats:
        """Best gain of every draw (draws,)."""
        scale = np.sqrt(np.maximum(np.diag(self.matrix), 1e-300))
        sizes, axes = np.linalg.eigh(self.matrix / np.outer(scale, scale))
        root = scale[:, None] * axes * np.sqrt(np.maximum(sizes, 0.0))
        drawn = np.random.default_rng(0).normal(size=(draws, len(sizes))) @ root.T
        best = np.full(draws, -np.inf)
        for columns, width, odds in zip(self.groups, self.widths, self.odds, strict=True):
            index = list(columns)
            gain = linear_gain(self.matrix[np.ix_(index, index)], drawn[:, index], width)
            best = np.maximum(best, gain + odds)
        return best


def threshold(kinds: Sequence[Candidates]) -> float:
    """Gain that the best candidate of all kinds together exceeds by chance with probability ERROR at most."""
    best = [k.best_on_nothing() for k in kinds if k.groups]
    return max((float(np.quantile(b, 1 - ERROR / len(best))) for b in best), default=0.0)
