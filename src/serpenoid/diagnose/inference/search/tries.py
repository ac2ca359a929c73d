"""Fits with one more effect, and with one less: which are tried, and how far each is fitted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.noise import residuals
from serpenoid.diagnose.inference.fits.finding import VISIBLE
from serpenoid.diagnose.inference.fits.medium import STEPS, Fit, candidates_of, fit, fit_guided, fit_on
from serpenoid.diagnose.inference.fits.rules import choose
from serpenoid.diagnose.inference.search.names import Try, each_without
from serpenoid.diagnose.inference.search.ranking import score, shortlist
from serpenoid.diagnose.inference.search.ratio_as_it_was import as_it_was, freed
from serpenoid.diagnose.inference.search.scans import Ranked
from serpenoid.effects.active import ActiveEffect
from serpenoid.parallel import in_processes

FULL_FITS = (10, 6, 4, 4, 4, 4, 4)
SCREENING, FINALISTS, OUT_OF_REACH = 3, 4, 20.0
SHARES = (1.0, 0.3, 0.1, 0.0)  # of the linear step: where it leads too far, steps have no root
UNCLEAR = 1 + VISIBLE**2  # chi squared per number: noise and a visible error


def off_by(motion: Motion, found: Fit) -> float:
    """Mean square of what windows are off by, in units of chance; where nothing was played again, and chance is all
    that is left, in units of the least that it can be: the markers' own noise."""
    if not motion.unrepeated:
        return found.chi2 / float(found.evidence.count.sum())
    left = residuals(motion.tracks, found.predictions)
    with np.errstate(divide="ignore", invalid="ignore"):  # markers without noise: then whatever is left is far off
        off = [x / t.least for t, x in zip(motion.tracks, left, strict=True)]
    return float(np.nanmean(np.concatenate(off) ** 2))


def unclear(found: Fit) -> bool:
    """Whether windows are left with much more than chance."""
    return bool(found.chi2 > UNCLEAR * found.evidence.count.sum())


def attempts(motion: Motion, base: Fit, promising: Sequence[Ranked]) -> list[Try]:
    """A few steps for all, and to the end for the best of them."""
    first = in_processes([(attempt, (motion, base, e, x, SCREENING)) for e, _, x in promising])
    first.sort(key=lambda t: t.fit.chi2)
    ahead = [t for t in first[:FINALISTS] if t.fit.chi2 < OUT_OF_REACH * first[0].fit.chi2]
    return in_processes([(finished, (motion, t)) for t in ahead])


def beside(motion: Motion, rival: Try, count: int) -> list[Try]:
    """What goes with another first effect: the first choice may have bent itself around a second that was missing."""
    base = fit_guided(motion, rival.fit)
    return attempts(motion, base, shortlist(score(motion, base), count))


def beside_the_earlier_ratio(motion: Motion, null: Fit) -> list[Try]:
    """Beside a reference, from eps as it was, where another one takes most of what has changed: it may have bent itself
    around what is missing."""
    base = as_it_was(motion, null)
    if base is None:
        return []
    base = freed(base, null)
    return attempts(motion, base, shortlist(score(motion, base), FULL_FITS[0]))


def from_typical(motion: Motion, base: Fit, every: bool = True) -> list[Ranked]:
    """Effects without a place, from moderate values: neutral ones are too far off to tell. every: not only those that
    remember the steps before."""
    barred = motion.untestable | {e.name for e in base.effects}
    absent = (c for c in candidates_of(base) if c.place is None and c.name not in barred)
    typical = [ActiveEffect.typical(c.name) for c in absent if every or c.effect.remembers]
    return [(e, 0.0, np.concatenate([base.coordinates, e.coordinates[:-1]])) for e in typical]


def at_other_places(motion: Motion, base: Fit, tries: Sequence[Try]) -> list[Ranked]:
    """The likeliest effect, from as much of it, at all places where it was not tried, if more is left than chance and
    it is larger than a moderate one: where neutral ones are too far off to tell, they do not tell places either."""
    likely = min(tries, key=lambda t: t.fit.chi2, default=None)
    if likely is None or likely.added.place is None or not unclear(likely.fit):
        return []
    fitted, tried = likely.fitted, {t.added.key for t in tries}
    numbers = fitted.effect.parameters
    change = np.array(fitted.coordinates[:-1]) - motion.unchanged(fitted)
    if not any(abs(x) > abs(p.coordinate(p.typical) - p.resting) for x, p in zip(change, numbers, strict=True)):
        return []
    return [r for r in as_much_elsewhere(motion, base, fitted) if r[0].key not in tried]


def as_much_elsewhere(motion: Motion, base: Fit, fitted: ActiveEffect) -> list[Ranked]:
    """As much of an effect at each of its other places."""
    change = np.array(fitted.coordinates[:-1]) - motion.unchanged(fitted)
    others = [c for c in candidates_of(base) if c.name == fitted.name and c.key != fitted.key]
    return [(c, 0.0, np.concatenate([base.coordinates, motion.unchanged(c) + change])) for c in others]


def finished(motion: Motion, t: Try, steps: int = STEPS) -> Try:
    """Fitted on, if more can be gained."""
    found = t.fit if t.fit.converged else fit_on(motion, t.fit, steps)
    return Try(found, t.added)


def attempt(motion: Motion, base: Fit, added: ActiveEffect, x: np.ndarray, steps: int) -> Try:
    """Fit the base's effects and one more in full."""
    neutral, whole = np.concatenate([base.coordinates, added.coordinates[:-1]]), float(base.evidence.count.sum())
    for share in SHARES:
        start = neutral + share * (x - neutral)
        least = whole if share else 0.0  # the last is taken as it is
        found = fit(motion, base.model, [*base.effects, added], start, steps, base.predictions, least)
        if found.evidence.count.sum() >= whole:
            break
    return Try(found, added)


def pruned(motion: Motion, best: Fit, tries: int) -> Fit:
    """Without effects that no longer earn their place."""
    if len(best.effects) < 2:
        return best
    for without in each_without(motion, best):
        if choose(without, [best], tries) is None:
            return pruned(motion, without, tries)
    return best
