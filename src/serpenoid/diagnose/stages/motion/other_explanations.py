"""The change beside another explanation of what the law of a reference misses than the one that leaves least there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.paths import apart, total
from serpenoid.diagnose.data.noise.shared import discrepancy
from serpenoid.diagnose.data.windows.tracks import NoPath
from serpenoid.diagnose.inference.doubt.explanations import Likely, another, chance_alone, likely
from serpenoid.diagnose.inference.fits.finding import Rival
from serpenoid.diagnose.inference.fits.medium import TO_THE_END, Fit, fit
from serpenoid.diagnose.inference.search.discrepancy import by_gait, worse
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.diagnose.stages.baseline import Baseline


def beside_others(
    found: Selection,
    baseline: Baseline,
    again: Callable[[Baseline], Selection],
    bare: Callable[[Baseline], tuple[Motion, Fit]],
) -> tuple[Selection, Baseline, Selection | None]:
    """Where what is left is news, the change beside the explanation of what the baseline's law misses that makes both
    likeliest, and that explanation as the baseline. It may be that beside another one nothing has changed; bare: the
    motion beside an explanation, and eps alone. And what was found first, if something else, and gaits do not exclude
    it."""
    motion = found.motion
    if not discrepancy(motion, found.settled.predictions):
        return found, baseline, None
    own = likely(motion, found.best, 1.0)
    others = beside_each(found, own, baseline, bare)
    unchanged = [likely(o.motion, o.null, o.weight).over(own) for o in others]
    if unchanged and max(unchanged) > 1:
        other = others[int(np.argmax(unchanged))].baseline
        return again(other), other, None
    if not found.best.effects:
        return found, baseline, None
    several = [(motion, baseline.model, 1.0), *((o.motion, o.null.model, o.weight) for o in others)]
    index = another(found, several)
    if index is None:
        return found, baseline, None
    other = others[index - 1].baseline
    anew = again(other)
    both = likely(anew.motion, anew.best, several[index][2]), own
    if not anew.best.effects or both[0].over(both[1]) <= 1:
        return found, baseline, None
    return anew, other, found if _open(found, anew) else None


def _open(found: Selection, anew: Selection) -> bool:
    """Whether gaits leave open which of two answers that name something else it is, each beside its explanation."""
    if {e.key for e in found.best.effects} <= {e.key for e in anew.best.effects}:
        return False
    alike = replace(anew.motion, noise=found.motion.noise)
    return not worse(by_gait(found.motion, found.best), by_gait(alike, anew.best))


def instead(chosen: Selection, first: Selection | None) -> tuple[Rival, ...]:
    """What another answer, beside an explanation of its own, names in the place of what is named."""
    if first is None or not chosen.best.effects:
        return ()
    gains = [base.chi2 - chosen.best.chi2 for base in chosen.bases]
    most, mine = chosen.best.effects[int(np.argmax(gains))], {e.key for e in chosen.best.effects}
    pairs = [_whole(chosen), _whole(first)]
    tracks = chosen.motion.tracks
    size = total([apart(t, one, other) for t, one, other in zip(tracks, *pairs, strict=True)])
    others = [e for e in first.best.effects if e.key not in mine]
    return tuple(Rival(e, most, size / chosen.noise_level_m) for e in others)


def _whole(found: Selection) -> list[Floats]:
    """What an answer predicts of each trial's windows (B - 1, 3), with what its baseline is known to get wrong."""
    pairs = zip(found.motion.tracks, found.best.predictions, strict=True)
    return [p.displacement + t.offset for t, p in pairs]


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
