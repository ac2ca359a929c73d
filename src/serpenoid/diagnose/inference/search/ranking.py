"""Every candidate of the stage of motion at once: its gain to first order."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.inference.fits.medium import Fit, candidates_of, linearised
from serpenoid.diagnose.inference.search.null import Scored, largest_by_chance
from serpenoid.diagnose.inference.search.scans import Ranked, on_offer, score_scanned, with_scanned
from serpenoid.effects.active import ActiveEffect
from serpenoid.files.store import remembered

PER_NAME = 4


@remembered
def score(motion: Motion, base: Fit) -> list[Ranked]:
    """Every candidate: gain to first order, less what its parameters gain by chance; where its full fit begins."""
    singles, scored = _singles(motion, base)
    evidence, own, result = scored.evidence, scored.own, []
    gains = evidence.gains(range(own), scored.groups)
    for c, new, (gained, values) in zip(singles, scored.groups, gains, strict=True):
        x = np.concatenate([base.coordinates, c.coordinates[:-1]]) + values
        if c.with_coordinates(x[own:].tolist()).coordinates != c.coordinates:  # else all of it is out of bounds
            result.append((c, gained - evidence.toll(len(new)), x))
    result += score_scanned(motion, base, on_offer(motion, base))
    return sorted(result, key=lambda r: -r[1])


@remembered
def needed(motion: Motion, found: Fit) -> float:
    """Chi squared that an effect of a fit must take away: the best of all candidates takes as much by chance."""
    singles, scored = _singles(motion, found)
    # to first order what remembers explains all pauses
    instant = tuple(g for g, c in zip(scored.groups, singles, strict=True) if not c.effect.remembers)
    every = [Scored(scored.evidence, scored.own, instant)]
    if grids := on_offer(motion, found):
        evidence = with_scanned(motion, found, grids)
        columns = range(scored.own, evidence.matrix.shape[1])
        every.append(Scored(evidence, scored.own, tuple((column,) for column in columns)))
    return largest_by_chance(every)


def _singles(motion: Motion, base: Fit) -> tuple[list[ActiveEffect], Scored]:
    """Candidates that are linear in columns of their own, and their evidence."""
    present = {e.name for e in base.effects}
    singles = [c for c in candidates_of(base) if c.name not in present or c.place is not None]
    singles = [c for c in singles if c.name not in motion.untestable]
    evidence, _ = linearised(motion, base.model, base.effects, singles, near=base.predictions)
    own = len(base.coordinates)
    ends = np.cumsum([own, *(len(c.effect.parameters) for c in singles)])
    groups = tuple(tuple(range(a, b)) for a, b in zip(ends[:-1], ends[1:], strict=True))
    return singles, Scored(evidence, own, groups)


def shortlist(ranked: Sequence[Ranked], count: int) -> list[Ranked]:
    """The best, but no more than a few of one name; of those on a grid, whose places are fitted, one of each size."""
    taken: dict[tuple[str, float | None], int] = {}
    result = []
    for item in ranked:
        scan = item[0].effect.scan
        size = None if scan is None else item[0].parameters[scan.size]
        kind, limit = (item[0].name, size), PER_NAME if size is None else 1
        if taken.get(kind, 0) < limit:
            result.append(item)
            taken[kind] = taken.get(kind, 0) + 1
        if len(result) == count:
            break
    return result
