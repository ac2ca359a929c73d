"""Which effects of the medium: linear scores of all candidates, full fits of the best, forward selection with pruning.

"Nothing" always competes. An effect must gain more than its parameters and the number of tries gain by chance; what of
all that was found is named, names.py says.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.paths import path_noise
from serpenoid.diagnose.data.noise.shared import discrepancy
from serpenoid.diagnose.data.windows.tracks import NoPath
from serpenoid.diagnose.data.windows.windows import Track
from serpenoid.diagnose.inference.fits.finding import VISIBLE
from serpenoid.diagnose.inference.fits.medium import (
    STEPS,
    TO_THE_END,
    Fit,
    candidates_of,
    fit_eps,
    fit_guided,
    fit_without,
)
from serpenoid.diagnose.inference.fits.places import placed
from serpenoid.diagnose.inference.fits.prices import gained_by_chance
from serpenoid.diagnose.inference.fits.rules import choose
from serpenoid.diagnose.inference.search.all_places import all_at_once
from serpenoid.diagnose.inference.search.discrepancy import deviance, information_criterion
from serpenoid.diagnose.inference.search.names import Kept, Key, Try, bare_of, kept, trace
from serpenoid.diagnose.inference.search.ranking import PER_NAME, needed, score, shortlist
from serpenoid.diagnose.inference.search.room import chance
from serpenoid.diagnose.inference.search.tries import (
    FULL_FITS,
    UNCLEAR,
    at_other_places,
    attempts,
    beside,
    beside_the_earlier_ratio,
    from_typical,
    off_by,
    pruned,
    unclear,
)
from serpenoid.effects.active import ActiveEffect
from serpenoid.model import Model
from serpenoid.parallel import meanwhile

AT_MOST = 7
HOPELESS = 0.5  # of the price of so many tries: what gains less to first order is not fitted in full
SHARE = 0.03  # of the best: what earns a full fit
IDLE = 3  # effects in a row that gain no more than the null: two may come before the one that makes them tell
FAR = 25.0  # chi squared per number: first-order scores of what is so wrong are not to be trusted

Progress = Callable[[str], None]
Retrack = Callable[[Model], tuple[Track, ...]]


@dataclass(frozen=True)
class Selection(Kept):
    """What is kept of a search on `motion`; null: eps alone."""

    motion: Motion
    null: Fit
    noise_level_m: float
    scores: tuple[tuple[str, int | None, float], ...]

    @property
    def extensions(self) -> tuple[Fit, ...]:
        """Fits with more than is named, which may predict better: with what is too weak, with all that was found."""
        weaker = (self.settled,) if self.undetected else ()
        return (*weaker, *(r.fit for r in self.refused[:1]))


def calibrated(motion: Motion, base: Fit) -> tuple[Motion, Fit]:
    """Noise from repeats about a fit, and the fit with it."""
    motion = replace(motion, noise=chance(motion, base))
    return motion, fit_guided(motion, base, TO_THE_END)


def select(motion: Motion, model: Model, retrack: Retrack, say: Progress) -> Selection:
    """Forward selection from eps alone. `retrack` makes the tracks again about the chosen model: its own mesh error."""
    motion, null = calibrated(motion, fit_eps(motion, model))
    again = placed(motion, null)
    if again is not motion:
        motion, null = calibrated(again, fit_guided(again, null))
    best, about = null, model
    hidden: tuple[Key, ...] = ()  # whose traces are below detection
    rival: Try | None = None  # what else might have come first
    scores: tuple[tuple[str, int | None, float], ...] = ()
    idle = 0
    passed: list[Fit] = []
    for level in range(AT_MOST):
        say(f"looking for effect {level + 1} beside {model.law.title}")
        ranked = score(motion, best)
        scores = scores or tuple((e.name, e.place, s) for e, s, _ in ranked)
        if not ranked:  # whatever may act would have to act backwards
            break
        worth = max(HOPELESS * gained_by_chance(len(ranked)), SHARE * ranked[0][1])
        promising = [r for r in shortlist(ranked, FULL_FITS[level]) if r[1] > worth]
        tries = attempts(motion, best, promising)
        if all(off_by(motion, t.fit) > FAR for t in tries):
            tries += attempts(motion, best, from_typical(motion, best, every=not level or motion.unrepeated))
        tries += attempts(motion, best, at_other_places(motion, best, tries))
        if not level:
            tries += beside_the_earlier_ratio(motion, null)
        least_left = min(f.chi2 for f in (best, *(t.fit for t in tries)))
        if rival is not None and least_left > UNCLEAR * best.evidence.count.sum():
            tries += beside(motion, rival, FULL_FITS[level])
        chosen = choose(best, [t.fit for t in tries], len(ranked))
        if chosen is None:
            break
        first, added = tries[chosen].fit, tries[chosen].added
        others = [t for t in tries if t.added.name != added.name and not best.effects]
        rival = min(others, key=lambda t: t.fit.chi2, default=None)
        with meanwhile(needed, motion, first) as least:
            again = placed(retracked(motion, retrack, first.model), first)
            idle = 0 if best.chi2 - first.chi2 > least() else idle + 1
        motion, first = settled(again, first, about, retrack)
        null, about = fit_guided(motion, null, STEPS), first.model
        best = pruned(motion, first, len(ranked))
        passed.append(best)
        if all(e.key != added.key for e in best.effects):
            break
        # repeats differ by what is missing, too, until it is there; and without what it makes needless it may tell more
        noise_level = path_noise(motion, best.predictions).level_m
        astray = level > 0 and motion.ratio is None and unclear(best)
        later = astray or motion.unrepeated  # what is missing may hide it: it is judged in the end
        base = null if len(best.effects) == 1 else fit_without(motion, best, added)
        if not later and trace(motion, best, base, added) < VISIBLE * noise_level:
            hidden = (*hidden, added.key)
        if idle == IDLE:
            break
    everywhere = partial(all_at_once, tries=len(candidates_of(null)))
    for better in (partial(likeliest, passed=passed), everywhere, one_for_several):
        other = better(motion, best)
        if other is not best:
            motion, best = settled(placed(retracked(motion, retrack, other.model), other), other, about, retrack)
            null, about = fit_guided(motion, null, STEPS), best.model
    noise_level = path_noise(motion, best.predictions).level_m
    best = resited(motion, best)
    found = kept(motion, null, best, noise_level, hidden)
    return Selection(**vars(found), motion=motion, null=null, noise_level_m=noise_level, scores=scores)


def likeliest(motion: Motion, best: Fit, passed: Sequence[Fit]) -> Fit:
    """Of what the search came by and what it ended with, the likeliest, errors of the law included: it goes on by chi
    squared, and where the law is wrong, what comes after a cause may only mend the law, and take the cause's place."""
    if not discrepancy(motion, best.predictions):
        return best
    keys = {frozenset(e.key for e in f.effects): f for f in (*passed, best)}
    others = [fit_guided(motion, f, TO_THE_END) for f in keys.values() if f is not best]
    whole = best.evidence.count.sum()
    several = [best, *(f for f in others if f.evidence.count.sum() >= whole)]
    return min(several, key=lambda f: information_criterion(motion, f))


def one_for_several(motion: Motion, best: Fit) -> Fit:
    """With one effect in the place of all of its name, if that is likelier, errors of the law included: a payload is
    what takes the same share off all other vertices, and where the law is wrong these may have been found instead."""
    names = Counter(e.name for e in best.effects if e.place is not None)
    found = best
    for name in sorted(name for name, count in names.items() if count > 1):
        bare = bare_of(motion, best, [e for e in best.effects if e.name == name])
        tries = attempts(motion, bare, [r for r in score(motion, bare) if r[0].name == name])
        tries += attempts(motion, bare, at_other_places(motion, bare, tries))
        found = min([found, *(t.fit for t in tries)], key=lambda f: information_criterion(motion, f))
    return found


def resited(motion: Motion, best: Fit) -> Fit:
    """With effects of one name where they are likeliest together: two beside a place may have come before the place."""
    names = [e.name for e in best.effects if e.place is not None]
    if len(set(names)) == len(names):
        return best
    least = deviance(motion, best)[0]
    while True:
        twins = [e for e in best.effects if names.count(e.name) > 1]
        fits = [t.fit for e in twins for t in elsewhere(motion, best, e)]
        found = [deviance(motion, f)[0] for f in fits]
        if not fits or min(found) >= least:
            return best
        least, best = min(found), fits[int(np.argmin(found))]


def elsewhere(motion: Motion, best: Fit, effect: ActiveEffect) -> list[Try]:
    """Fits with an effect at other places, where it gains about as much to first order as at its own."""
    base, taken = fit_without(motion, best, effect), {e.key for e in best.effects}
    places = [r for r in score(motion, base) if r[0].name == effect.name]
    own = max((r[1] for r in places if r[0].key == effect.key), default=0.0)
    near = [r for r in places if r[0].key not in taken and r[1] > HOPELESS * own]
    return attempts(motion, base, shortlist(near, PER_NAME)) if near else []


def retracked(motion: Motion, retrack: Retrack, model: Model) -> Motion:
    """On tracks about a model, whose mesh is finer than that of the fits; as it is if the model has no path there.

    Nor has it one if the meshes differ by more than any window's motion: then one of them found a wrong root.
    """
    try:
        tracks = retrack(model)
    except NoPath:
        return motion
    moved = np.nanmax([np.nanmax(np.abs(t.displacement), axis=0) for t in tracks], axis=0)
    apart = np.max([np.abs(t.offset).max(axis=0) for t in tracks], axis=0)
    return replace(motion, tracks=tracks) if (apart <= moved).all() else motion


def settled(motion: Motion, found: Fit, about: Model, retrack: Retrack) -> tuple[Motion, Fit]:
    """A fit on tracks made about itself, until another time would not move it by a standard deviation: the mesh's
    error, and how poses are averaged, are those of a model; one with half of the inertia puts back half of its error.

    found: a fit to tracks made about the model `about`; motion: with tracks about the fit. Where a fit moves by x when
    the model that tracks are about moved by y, x^2 / y + x^3 / y^2 + .. = x^2 / (y - x) lies ahead.
    """
    before = found.away_from(about)
    while True:
        motion, again = calibrated(motion, fit_guided(motion, found))
        moved = again.away_from(found.model)
        if not moved < before or moved**2 <= before - moved:  # nothing is gained by going on, or no deviation
            return motion, again
        motion, found, before = placed(retracked(motion, retrack, again.model), again), again, moved
