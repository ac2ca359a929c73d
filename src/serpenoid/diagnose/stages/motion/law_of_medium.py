"""Which law the medium follows, where no file says so: what is named beside a rival, and which of the two is taken."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.windows.tracks import NoPath
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR
from serpenoid.diagnose.inference.doubt.laws import (
    Misfits,
    beyond_chance,
    by_its_own_numbers,
    misfits,
    missed,
    numbers_of,
    rival_laws,
    settled_numbers,
    takes_its_place,
)
from serpenoid.diagnose.inference.fits.bounds import LEAST_EPS, MOST_EPS
from serpenoid.diagnose.inference.fits.medium import Fit, fit_eps
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.diagnose.inference.search.tries import unclear
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.effects.catalogue import of_laws
from serpenoid.medium import MOST
from serpenoid.model import Model


@dataclass(frozen=True)
class Taken:
    """The law that is taken instead: what is found beside it, its baseline, and why, in words; None and empty: the
    same. rivals: how others do beside the one that is taken, in words by their names; misses: what the best of these
    misses windows by, over the noise."""

    selection: Selection | None = None
    baseline: Baseline | None = None
    words: str = ""
    rivals: dict[str, str] = field(default_factory=dict)
    misses: float = np.inf


SAME = Taken()
SIDEWAYS = (2.0, 10.0)  # eps at which fits of bodies begin that slip more easily sideways
ROUNDS = 3  # a number of the law moves by what is named beside it, and what is named by that


def law_of(
    found: Selection, baseline: Baseline, search: Callable[[Baseline], Selection], elsewhere: float = np.inf
) -> Taken:
    """The first rival, from the one that misses least, with which the explanation is likelier, and which leaves less
    than LAW_ERROR of what the law alone leaves beyond chance: as of servos, a law that leaves more is not the one.

    search: finds what is to be named beside a baseline. elsewhere: what the law itself misses windows by, over the
    noise, or another one, where the drag sits elsewhere on the body; a law that misses as much is not the reason.
    """
    rivals = rival_laws(found, baseline.without)
    for rival in (r for r in rivals.values() if r.promising and baseline.law_open):
        other = replace(baseline, model=rival.model)
        try:
            selection, other = numbers_settled(search(other), other, search)
        except NoPath:  # not the law by which the body moved
            continue
        left = misfits(found, selection)
        if left.beside < elsewhere and takes_its_place(found, selection, left, LAW_ERROR):
            return Taken(selection, other, in_words(found, selection, left, other))
    open_question = unclear(found.best)
    asked = {name: r for name, r in rivals.items() if r.words and (r.better or open_question) and r.misses < elsewhere}
    told = {name: r.words for name, r in asked.items()}
    return Taken(rivals=told, misses=min((r.misses for r in asked.values()), default=np.inf))


def in_words(found: Selection, other: Selection, left: Misfits, baseline: Baseline) -> str:
    """Why the other law is taken, and the numbers that its baseline has: both misfits of the law itself decide."""
    digits = 1 if round(left.named, 1) != round(left.beside, 1) else 2
    alone = f" (and alone by {left.alone:.{digits}f})" if found.best.effects else ""
    (before, then), (after, now) = (
        (s.null.model.law.title + (" with what is named" if s.best.effects else ""), f"{misfit:.{digits}f}")
        for s, misfit in zip((found, other), (left.named, left.beside), strict=True)
    )
    own = (e for e in baseline.model.effects if e.effect in of_laws())
    numbers = [
        f"{p.name} {e.parameters[p.name]:.3g} {p.unit}".removesuffix(" 1") for e in own for p in e.effect.parameters
    ]
    beside = f" with {', '.join(numbers)}" if numbers else ""
    return f"{after} misses windows by {now} times the noise, {before} by {then}{alone}: it is taken{beside}"


def numbers_settled(
    found: Selection, baseline: Baseline, search: Callable[[Baseline], Selection]
) -> tuple[Selection, Baseline]:
    """What is found beside a baseline whose law has the numbers that it has beside what is found, unless they were
    measured before."""
    for _ in range(ROUNDS):
        model = settled_numbers(found) if baseline.ratio is None else None
        if model is None:
            break
        other = replace(baseline, model=model)
        try:
            found, baseline = search(other), other
        except NoPath:
            break
    return found, baseline


def with_own_numbers(baseline: Baseline, motion: Callable[[Baseline], Motion]) -> Baseline:
    """A baseline whose model has all numbers of its law; motion: as it is beside a baseline."""
    model = baseline.model
    if baseline.ratio is not None or not numbers_of(model, baseline.without):
        return baseline
    found = by_its_own_numbers(motion(baseline), model, LEAST_EPS, baseline.without)
    return replace(baseline, model=found.model) if np.isfinite(found.chi2) and found.evidence.count.sum() else baseline


def slipping_sideways(baseline: Baseline, alone: Callable[[Baseline], tuple[Motion, Fit]]) -> Baseline:
    """A baseline whose eps may be above 1, where no file says how far it may go and the body moves the way its bends
    run: eps alone ends at 1, and beyond it leaves less than LAW_ERROR of that. alone: eps fitted beside a baseline."""
    model = baseline.model
    if baseline.ratio is not None or model.medium.anisotropy_ratio_bounds is not None:
        return baseline
    motion, found = alone(baseline)
    if found.model.medium.anisotropy_ratio < MOST_EPS:
        return baseline
    tried = [fit_eps(motion, _reaching(found.model, ratio)) for ratio in SIDEWAYS]
    beyond = min(tried, key=missed)
    if not beyond_chance(np.sqrt(missed(beyond))) < LAW_ERROR * beyond_chance(np.sqrt(missed(found))):
        return baseline
    return replace(baseline, model=_reaching(model, beyond.model.medium.anisotropy_ratio))


def _reaching(model: Model, ratio: float) -> Model:
    """The model with eps above 1, free to go as far as it may."""
    return replace(model, medium=model.medium.with_ratio(ratio).within(LEAST_EPS, MOST))
