"""Every candidate of the stage of motion at once: its gain on held-out gaits to first order."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.inference.medium import Fit, candidates_of, linearised
from serpenoid.diagnose.inference.patches import Ranked, score_patches
from serpenoid.files.store import remembered

PER_NAME = 4


@remembered
def score(motion: Motion, base: Fit) -> list[Ranked]:
    """Every candidate: gain on held-out gaits to first order, and where its full fit begins; best first."""
    drift = {e.name for e in base.effects}
    singles = [c for c in candidates_of(base) if c.name not in drift or c.place is not None]
    singles = [c for c in singles if c.name not in motion.untestable]
    evidence, _, _ = linearised(motion, base.model, base.effects, base.drift, singles, near=base.predictions)
    evidence, own = base.shrinking(evidence), list(range(len(base.coordinates)))
    before, at, result = evidence.held_out(own), len(own), []
    for c in singles:
        size = len(c.effect.parameters)
        new = list(range(at, at + size))
        index = own + new
        at += size
        values, _ = evidence.solve(index)
        x = np.concatenate([base.coordinates, c.coordinates[:-1]]) + values
        if c.with_coordinates(x[len(own) :].tolist()).coordinates != c.coordinates:  # else all of it is out of bounds
            shrunk = evidence.shrinking(new, values[len(own) :], np.zeros(size))
            result.append((c, before - shrunk.held_out(index), x))
    if "friction_patch" not in drift | motion.untestable:
        result += score_patches(motion, base, before, own)
    return sorted(result, key=lambda r: -r[1])


def shortlist(ranked: Sequence[Ranked], count: int) -> list[Ranked]:
    """The best, but no more than a few of one name (of patches, whose places are fitted, two)."""
    taken: dict[str, int] = {}
    result = []
    for item in ranked:
        name = item[0].name
        limit = 2 if name == "friction_patch" else PER_NAME
        if taken.get(name, 0) < limit:
            result.append(item)
            taken[name] = taken.get(name, 0) + 1
        if len(result) == count:
            break
    return result
