"""Every candidate of the stage of motion at once: its gain to first order."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.inference.medium import Fit, candidates_of, linearised
from serpenoid.diagnose.inference.null import Scored, largest_by_chance
from serpenoid.diagnose.inference.patches import Ranked, score_patches, with_patches
from serpenoid.effects.active import ActiveEffect
from serpenoid.files.store import remembered

PER_NAME = 4


@remembered
def score(motion: Motion, base: Fit) -> list[Ranked]:
    """Every candidate: gain to first order, less what its parameters gain by chance; where its full fit begins."""
    singles, scored = _singles(motion, base)
    evidence, own, result = scored.evidence, list(range(scored.own)), []
    before = evidence.chi2(own)
    for c, new in zip(singles, scored.groups, strict=True):
        index = [*own, *new]
        values, _ = evidence.solve(index)
        x = np.concatenate([base.coordinates, c.coordinates[:-1]]) + values
        if c.with_coordinates(x[len(own) :].tolist()).coordinates != c.coordinates:  # else all of it is out of bounds
            result.append((c, before - evidence.chi2(index) - evidence.toll(len(new)), x))
    if _patches_on_offer(motion, base):
        result += score_patches(motion, base, own)
    return sorted(result, key=lambda r: -r[1])


@remembered
def needed(motion: Motion, found: Fit) -> float:
    """Chi squared that an effect of a fit must take away: the best of all candidates takes as much by chance."""
    singles, scored = _singles(motion, found)
    remembers = ["history" in getattr(c.effect, "knows", ()) for c in singles]
    # to first order what remembers explains all pauses
    instant = tuple(g for g, r in zip(scored.groups, remembers, strict=True) if not r)
    every = [Scored(scored.evidence, scored.own, instant)]
    if _patches_on_offer(motion, found):
        evidence, patches = with_patches(motion, found)
        every.append(Scored(evidence, scored.own, tuple((scored.own + i,) for i in range(len(patches)))))
    return largest_by_chance(every)


def _singles(motion: Motion, base: Fit) -> tuple[list[ActiveEffect], Scored]:
    """Candidates that are linear in columns of their own, and their evidence."""
    present = {e.name for e in base.effects}
    singles = [c for c in candidates_of(base) if c.name not in present or c.place is not None]
    singles = [c for c in singles if c.name not in motion.untestable]
    evidence, _, _ = linearised(motion, base.model, base.effects, base.drift, singles, near=base.predictions)
    own = len(base.coordinates)
    ends = np.cumsum([own, *(len(c.effect.parameters) for c in singles)])
    groups = tuple(tuple(range(a, b)) for a, b in zip(ends[:-1], ends[1:], strict=True))
    return singles, Scored(evidence, own, groups)


def _patches_on_offer(motion: Motion, base: Fit) -> bool:
    return "friction_patch" not in {e.name for e in base.effects} | motion.untestable


def shortlist(ranked: Sequence[Ranked], count: int) -> list[Ranked]:
    """The best, but no more than a few of one name; of patches, whose places are fitted, one of each size."""
    taken: dict[tuple[str, float | None], int] = {}
    result = []
    for item in ranked:
        size = item[0].parameters["radius"] if item[0].name == "friction_patch" else None
        kind, limit = (item[0].name, size), PER_NAME if size is None else 1
        if taken.get(kind, 0) < limit:
            result.append(item)
            taken[kind] = taken.get(kind, 0) + 1
        if len(result) == count:
            break
    return result
