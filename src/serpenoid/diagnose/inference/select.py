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

from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.data.noise import residuals
from serpenoid.diagnose.data.paths import path_noise
from serpenoid.diagnose.data.shared import discrepancy
from serpenoid.diagnose.data.tracks import NoPath
from serpenoid.diagnose.data.windows import Track
from serpenoid.diagnose.inference.discrepancy import deviance, information_criterion
from serpenoid.diagnose.inference.evidence import SILENT
from serpenoid.diagnose.inference.finding import VISIBLE
from serpenoid.diagnose.inference.medium import (
    STEPS,
    TO_THE_END,
    Fit,
    candidates_of,
    coordinates_of,
    fit,
    fit_eps,
    fit_guided,
    fit_on,
    fit_without,
    moved,
)
from serpenoid.diagnose.inference.names import Kept, Key, Try, bare_of, each_without, kept, trace
from serpenoid.diagnose.inference.places import placed
from serpenoid.diagnose.inference.prices import gained_by_chance
from serpenoid.diagnose.inference.ranking import PER_NAME, needed, score, shortlist
from serpenoid.diagnose.inference.ratio_as_it_was import as_it_was, freed
from serpenoid.diagnose.inference.room import chance
from serpenoid.diagnose.inference.rules import choose
from serpenoid.diagnose.inference.scans import Ranked
from serpenoid.effects.active import ActiveEffect
from serpenoid.model import Model
from serpenoid.parallel import in_processes, meanwhile

AT_MOST = 7
FULL_FITS = (10, 6, 4, 4, 4, 4, 4)
SCREENING, FINALISTS, OUT_OF_REACH = 3, 4, 20.0
HOPELESS = 0.5  # of the price of so many tries: what gains less to first order is not fitted in full
SHARE = 0.03  # of the best: what earns a full fit
IDLE = 3  # effects in a row that gain no more than the null: two may come before the one that makes them tell
SHARES = (1.0, 0.3, 0.1, 0.0)  # of the linear step: where it leads too far, steps have no root
FAR = 25.0  # chi squared per number: first-order scores of what is so wrong are not to be trusted
UNCLEAR = 1 + VISIBLE**2  # the same: noise and a visible error

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
        tries += attempts(motion, best, at_other_places(best, tries))
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
        tries += attempts(motion, bare, at_other_places(bare, tries))
        found = min([found, *(t.fit for t in tries)], key=lambda f: information_criterion(motion, f))
    return found


def all_at_once(motion: Motion, best: Fit, tries: int) -> Fit:
    """Where much is left, with all places of one effect, less those that earn nothing, if that is likelier, errors of
    the law included, and foretells gaits better: of several wheels that are worn together the first that is found may
    be a place between two. So many numbers fit any law on one gait alone, and mend any law's error; so do more places
    than a body of so many joints has vertices, if none lie between its joints."""
    if not unclear(best) or len(best.evidence.constant) < 2:
        return best
    everywhere = [c for c in (*best.effects, *candidates_of(best)) if c.name not in motion.untestable]
    waiting = sorted({c.name for c in everywhere if c.place is not None and len(c.effect.parameters) == 1})
    while waiting:
        found = in_processes([(_of_all_places, (motion, best, everywhere, name, tries)) for name in waiting])
        likelier = [i for i, f in enumerate(found) if f is not None and _foretells(motion, best, f, tries)]
        if not likelier:
            break
        best, waiting = pruned(motion, found[likelier[0]], tries), waiting[likelier[0] + 1 :]  # fitted anew beside it
    return best


def _of_all_places(motion: Motion, best: Fit, everywhere: Sequence[ActiveEffect], name: str, tries: int) -> Fit | None:
    """A fit with all places of one effect, less those that earn nothing; None where more than a body may have do."""
    others, most = [e for e in best.effects if e.name != name], best.model.body.joint_count + 2  # without middles
    effects = [*others, *(c for c in everywhere if c.name == name)]
    found = fit(motion, best.model, effects, coordinates_of(best.model, effects), TO_THE_END, best.predictions)
    if len(effects) - len(others) > most and _telling(found, name, tries) > most:
        return None
    return told(motion, found, tries)


def _foretells(motion: Motion, best: Fit, other: Fit, tries: int) -> bool:
    """Whether another fit is likelier, errors of the law included, and foretells gaits better."""
    better = choose(best, [other], tries) is not None and _foretold(other) < _foretold(best)
    return better and information_criterion(motion, other) < information_criterion(motion, best)


def _telling(found: Fit, name: str, tries: int) -> int:
    """How many effects of a name gain more than their price beside those that are left, without the least first: all to
    first order, in which what a bound holds gains nothing."""
    silent = np.diagonal(found.evidence.matrix.sum(axis=0)) < SILENT
    left = [i for i, own in enumerate(found.columns) if found.effects[i].name != name or not silent[own[0]]]
    own = [i for i in left if found.effects[i].name == name]
    while own:
        gains = dict(zip(left, _gained(found, left), strict=True))
        least = min(own, key=gains.__getitem__)
        if gains[least] - found.evidence.toll(1) > gained_by_chance(tries):
            break
        left.remove(least)
        own.remove(least)
    return len(own)


def _foretold(found: Fit) -> float:
    """Chi squared of each gait by what the others tell, to first order."""
    return found.evidence.held_out(range(len(found.coordinates)))


def told(motion: Motion, found: Fit, tries: int) -> Fit:
    """Without effects that gain no more than their price (prices.py) beside those that are left, the least first: which
    it is, to first order; the others are fitted again."""
    while found.effects:
        gains = _gained(found, range(len(found.effects)))
        excess = [g - found.evidence.toll(len(e.effect.parameters)) for g, e in zip(gains, found.effects, strict=True)]
        least = int(np.argmin(excess))
        if excess[least] > gained_by_chance(tries):
            break
        found = fit_without(motion, found, found.effects[least])
    return fit_guided(motion, found, TO_THE_END)


def _gained(found: Fit, some: Sequence[int]) -> list[float]:
    """Chi squared that each of some effects takes away beside the others of them, to first order, in units of what is
    left; of one that its bound holds first order says nothing, and it stays."""
    resting = [p.resting for e in found.effects for p in e.effect.parameters]
    bare = found.evidence.about(
        found.coordinates - [found.coordinates[0], *resting]
    )  # chi squared of some, others none
    silent = np.diagonal(bare.matrix.sum(axis=0)) < SILENT
    columns = [found.columns[i] for i in some]
    every = [0, *(c for own in columns for c in own)]
    now = bare.chi2(every)
    spread, gains = max(1.0, now / float(bare.count.sum())), []
    for own in columns:
        held = bool(silent[list(own)].all() and any(moved(found, c) for c in own))
        gains.append(np.inf if held else (bare.chi2([c for c in every if c not in own]) - now) / spread)
    return gains


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


def at_other_places(base: Fit, tries: Sequence[Try]) -> list[Ranked]:
    """The likeliest effect, from as much of it, at all places where it was not tried, if more is left than chance and
    it is larger than a moderate one: where neutral ones are too far off to tell, they do not tell places either."""
    likely = min(tries, key=lambda t: t.fit.chi2, default=None)
    if likely is None or likely.added.place is None or not unclear(likely.fit):
        return []
    fitted, tried = likely.fitted, {t.added.key for t in tries}
    numbers = zip(fitted.coordinates, fitted.effect.parameters, strict=False)
    if not any(abs(x - p.resting) > abs(p.coordinate(p.typical) - p.resting) for x, p in numbers):
        return []
    others = [c for c in candidates_of(base) if c.name == fitted.name and c.key not in tried]
    return [(c, 0.0, np.concatenate([base.coordinates, fitted.coordinates[:-1]])) for c in others]


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
