"""Every candidate of the stage of motion at once: its gain of log posterior odds to first order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.inference.calibration import Candidates, threshold
from serpenoid.diagnose.inference.evidence import Evidence
from serpenoid.diagnose.inference.medium import Fit, candidates_of, linearised
from serpenoid.diagnose.inference.patches import Ranked, patch_evidence, patch_grid
from serpenoid.diagnose.inference.posterior import linear_gain, log_odds, projected
from serpenoid.diagnose.inference.prior import Prior
from serpenoid.effects.active import ActiveEffect
from serpenoid.files.store import remembered

PER_NAME = 4
WEAKEST, STRONGEST = -0.9, 3.0  # strength of a patch that a full fit may begin with


@dataclass(frozen=True)
class Scored:
    """ranked: candidates, best first, with gain and where their full fits begin; kinds: what they were scored from."""

    ranked: list[Ranked]
    kinds: tuple[Candidates, ...]

    @property
    def on_nothing(self) -> float:
        """Gain that the best of all candidates exceeds by chance at the stated rate."""
        return threshold(self.kinds)


@remembered
def score(motion: Motion, base: Fit) -> Scored:
    """Every candidate, under the noise and discrepancy of `motion`."""
    taken = {e.name for e in base.effects}
    singles = [c for c in candidates_of(base) if c.name not in taken or c.place is not None]
    singles = [c for c in singles if c.name not in motion.untestable]
    evidence, _, _ = linearised(motion, base.model, base.effects, base.drift, singles)
    found = [_scored(motion, base, evidence, singles, [len(c.effect.parameters) for c in singles])]
    if "friction_patch" not in taken | motion.untestable:
        grid = patch_grid(motion)
        found.append(_scored(motion, base, patch_evidence(motion, base, grid), grid, [1] * len(grid)))
    ranked = sorted((r for one, _ in found for r in one), key=lambda r: -r[1])
    return Scored(ranked, tuple(kinds for _, kinds in found))


def _scored(
    motion: Motion, base: Fit, evidence: Evidence, candidates: Sequence[ActiveEffect], sizes: Sequence[int]
) -> tuple[list[Ranked], Candidates]:
    """Of candidates whose columns follow the base's own; a patch of the grid brings its strength alone."""
    own = len(base.coordinates)
    width = Prior.of(motion, base.effects).widest(base.coordinates)
    matrix, vector = projected(evidence, range(own), range(own, evidence.matrix.shape[1]), width)
    starts = np.cumsum([0, *sizes])
    groups = tuple(tuple(range(a, a + n)) for a, n in zip(starts, sizes, strict=False))
    widths = tuple(Prior.of(motion, [c]).width[1 : 1 + n] for c, n in zip(candidates, sizes, strict=True))
    odds = np.array([log_odds(motion, c) for c in candidates])
    if candidates and candidates[0].name == "friction_patch":
        odds -= np.log(len(candidates))  # it may lie anywhere on the grid
    ranked: list[Ranked] = []
    for c, columns, width, odd in zip(candidates, groups, widths, odds, strict=True):
        index = list(columns)
        gain = float(linear_gain(matrix[np.ix_(index, index)], vector[index], width))
        values, _ = evidence.solve([*range(own), *(own + i for i in index)])
        x = _start(base, c, values)
        if x is not None:
            ranked.append((c, gain + float(odd), x))
    return ranked, Candidates(matrix, groups, widths, odds)


def _start(base: Fit, c: ActiveEffect, values: Floats) -> Floats | None:
    """Coordinates (1 + P) where a full fit begins; None where all of it is out of bounds."""
    own = len(base.coordinates)
    step = np.zeros(len(c.coordinates) - 1)
    step[: len(values) - own] = values[own:]
    there = np.array(c.coordinates[:-1]) + step
    if c.name == "friction_patch":
        there[0] = np.clip(there[0], WEAKEST, STRONGEST)
    elif c.with_coordinates(there.tolist()).coordinates == c.coordinates:
        return None
    return np.concatenate([base.coordinates + values[:own], there])


def shortlist(ranked: Sequence[Ranked], count: int) -> list[Ranked]:
    """The best, but no more than a few of one name; of patches, whose places are fitted, two of each sign."""
    taken: dict[str, int] = {}
    result = []
    for item in ranked:
        name, limit = item[0].name, PER_NAME
        if name == "friction_patch":
            name, limit = f"{name} {item[2][-len(item[0].parameters)] < 0}", 2
        if taken.get(name, 0) < limit:
            result.append(item)
            taken[name] = taken.get(name, 0) + 1
        if len(result) == count:
            break
    return result
