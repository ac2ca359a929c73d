"""The change beside another explanation of what the law of a reference misses than the one that leaves least there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.shared import discrepancy
from serpenoid.diagnose.data.windows.tracks import NoPath
from serpenoid.diagnose.inference.doubt.explanations import Likely, another, chance_alone, likely
from serpenoid.diagnose.inference.fits.medium import TO_THE_END, Fit, fit
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.diagnose.stages.baseline import Baseline


def beside_others(
    found: Selection,
    baseline: Baseline,
    again: Callable[[Baseline], Selection],
    bare: Callable[[Baseline], tuple[Motion, Fit]],
) -> tuple[Selection, Baseline]:
    """Where what is left is news, the change beside the explanation of what the baseline's law misses that makes both
    likeliest, and that explanation as the baseline. It may be that beside another one nothing has changed; bare: the
    motion beside an explanation, and eps alone."""
    motion = found.motion
    if not discrepancy(motion, found.settled.predictions):
        return found, baseline
    own = likely(motion, found.best, 1.0)
    others = beside_each(found, own, baseline, bare)
    unchanged = [likely(o.motion, o.null, o.weight).over(own) for o in others]
    if unchanged and max(unchanged) > 1:
        other = others[int(np.argmax(unchanged))].baseline
        return again(other), other
    if not found.best.effects:
        return found, baseline
    several = [(motion, baseline.model, 1.0), *((o.motion, o.null.model, o.weight) for o in others)]
    index = another(found, several)
    if index is None:
        return found, baseline
    other = others[index - 1].baseline
    anew = again(other)
    both = likely(anew.motion, anew.best, several[index][2]), own
    return (anew, other) if anew.best.effects and both[0].over(both[1]) > 1 else (found, baseline)


class Other(NamedTuple):
    """Another explanation of what the baseline's law misses: the motion on tracks about it, eps alone, its weight."""

    baseline: Baseline
    motion: Motion
    null: Fit
    weight: float


def beside_each(
    found: Selection, own: Likely, baseline: Baseline, bare: Callable[[Baseline], tuple[Motion, Fit]]
) -> list[Other]:
    """Every explanation of what the baseline's law misses beside which a change may be likelier than what was found:
    it is so if chance is all that is left there."""
    others = list[Other]()
    for _, model, weight in baseline.otherwise(found.motion):
        if chance_alone(found.motion, weight).over(own) <= 1:
            continue
        other = baseline.beside(model)
        try:
            motion, null = bare(other)
        except NoPath:
            continue
        if null.evidence.count.sum() >= found.null.evidence.count.sum():
            others.append(Other(other, replace(motion, noise=found.motion.noise), null, weight))
    return others


def beside_rivals(found: Selection, baseline: Baseline) -> tuple[tuple[Motion, Fit, float], ...]:
    """What is there, fitted again beside other explanations of what the baseline's law misses, where that can be."""
    effects, values = found.settled.effects, found.settled.coordinates
    fits = []
    for motion, model, weight in baseline.otherwise(found.motion) if found.best.effects else ():
        if {e.key for e in effects} & {e.key for e in model.effects}:
            continue  # what changed was a guess about the reference, too
        start = np.concatenate([[model.medium.anisotropy_ratio], values[1:]])
        fits.append((motion, fit(motion, model, effects, start, TO_THE_END), weight))
    whole = found.settled.evidence.count.sum()
    return tuple((m, f, weight) for m, f, weight in fits if f.evidence.count.sum() >= whole)
