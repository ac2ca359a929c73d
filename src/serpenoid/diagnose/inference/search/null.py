"""What a search finds on nothing: the largest gain of all candidates on draws of this campaign's own null.

The null: what a fit leaves is chance and a discrepancy that no candidate causes. A discrepancy belongs to a gait, and
what it is along a candidate's columns in one gait says nothing of the next. So every gait's score is multiplied by a
normal number of its own (the multiplier bootstrap of a maximum; Chernozhukov, Chetverikov and Kato, Annals of
Statistics 41, 2786, 2013) and chance is added. An effect that gains less than the best of all candidates would so gain
is no cause. Where chance is all that is left, this is the usual test with all tries counted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import ERROR
from serpenoid.diagnose.inference.fits.evidence import SILENT, Evidence

DRAWS = 2000
COLLINEAR = 1e-6  # of a column's square: what the fit's own columns leave of it says nothing


@dataclass(frozen=True)
class Scored:
    """Evidence about a fit; its first `own` columns are the fit's, the groups are the columns of each candidate."""

    evidence: Evidence
    own: int
    groups: tuple[tuple[int, ...], ...]


def largest_by_chance(candidates: Sequence[Scored]) -> float:
    """Chi squared that the best of all candidates gains with probability ERROR if none of them is a cause."""
    rng = np.random.default_rng(0)
    gaits = len(candidates[0].evidence.constant)
    multipliers = rng.normal(size=(DRAWS, gaits))
    best = np.zeros(DRAWS)
    for scored in candidates:
        above = _share_above_chance(scored.evidence)
        for scores in _whitened(scored):
            drawn = np.sqrt(above) * multipliers @ scores + rng.normal(size=(DRAWS, scores.shape[1]))
            best = np.maximum(best, (drawn**2).sum(axis=1))
    return float(np.quantile(best, 1 - ERROR))


def _share_above_chance(evidence: Evidence) -> float:
    left = float(evidence.constant.sum())
    return max(0.0, 1 - float(evidence.count.sum()) / left) if left > 0 else 0.0


def _whitened(scored: Scored) -> list[Floats]:
    """Of each candidate, the scores of the gaits (G, K) by its columns beside the fit's own, in units of chance."""
    e, own = scored.evidence, np.arange(scored.own)
    total = e.matrix.sum(axis=0)
    scale = np.sqrt(np.where(np.diag(total) > SILENT, np.diag(total), 1.0))
    total = total / np.outer(scale, scale)
    scores = e.vector / scale
    square = total[np.ix_(own, own)] + 1e-9 * np.eye(len(own))
    shared = np.linalg.solve(square, total[own])
    scores = scores - scores[:, own] @ shared
    found = []
    for group in scored.groups:
        index = np.array(group)
        rest = total[np.ix_(index, index)] - total[np.ix_(index, own)] @ shared[:, index]
        sizes, axes = np.linalg.eigh((rest + rest.T) / 2)
        speaks = sizes > COLLINEAR
        if speaks.any():
            found.append(scores[:, index] @ axes[:, speaks] / np.sqrt(sizes[speaks]))
    return found
