"""Which effects of the medium: scores of all candidates to first order, full fits of the best, adding and dropping.

An explanation's score is its log posterior (`posterior.py`), noise and discrepancy being the likeliest with it.
"Nothing" always competes: an effect must beat it by stated odds, by more than the same search finds on nothing
(`calibration.py`), and its trace in the path must stand above the noise level.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.data.noise import path_error, path_noise, residuals, strength, window_noise
from serpenoid.diagnose.data.windows import Track
from serpenoid.diagnose.inference.held_out import Rule
from serpenoid.diagnose.inference.medium import (
    STEPS,
    Fit,
    candidates_of,
    fit,
    fit_eps,
    fit_guided,
    fit_without,
    predicted_without,
)
from serpenoid.diagnose.inference.patches import Ranked
from serpenoid.diagnose.inference.posterior import Explanation, explained
from serpenoid.diagnose.inference.ranking import Scored, score, shortlist
from serpenoid.effects.active import ActiveEffect
from serpenoid.model import Model
from serpenoid.parallel import in_processes

AT_MOST = 7
ODDS = 100.0  # posterior odds that name an effect
FULL_FITS = (10, 6, 4, 4, 4, 4, 4)
DOUBTED = 5  # full fits of what ranks best beside the discrepancy
SCREENING, FINALISTS, OUT_OF_REACH = 3, 4, 20.0
TO_THE_END = 60  # steps of what was chosen: along curved valleys (eps against dry friction) eight are not enough
PROMISING, SHARE = 0.5, 0.03  # of what is needed, of the best: what earns a full fit
REFITTED = 2  # explanations fitted again under their own discrepancy
SHARES = (1.0, 0.3, 0.1, 0.0)  # of the linear step: where it leads too far, steps have no root
VISIBLE = 1.6  # noise levels of the path: a weaker trace is below detection, and does not stay below one
FAR = 25.0  # chi squared per number: first-order scores of what is so wrong are not to be trusted
UNCLEAR = 2.0  # the same: with the right effects there is less

FIRST_ORDER = Rule()
Progress = Callable[[str], None]
Retrack = Callable[[Model], tuple[Track, ...]]


@dataclass(frozen=True)
class Try:
    """A full fit with one more (or another) effect."""

    fit: Fit
    added: ActiveEffect
    strength_m: float

    @property
    def fitted(self) -> ActiveEffect:
        """The added effect with its fitted values."""
        return next(e for e in self.fit.effects if e.key == self.added.key)


@dataclass(frozen=True)
class Undetected:
    """A try that gains but does not stand out, fitted on tracks made about it."""

    attempt: Try
    motion: Motion


@dataclass(frozen=True)
class Selection:
    """null: eps alone; best: what was chosen; bases: it without each of its effects; undetected: gains below noise.

    All fits are under the noise and discrepancy of `motion`, the likeliest with `best`.
    scores: gains of log posterior odds to first order, beside eps alone; needed: what they are measured by.
    """

    motion: Motion
    null: Fit
    best: Fit
    bases: tuple[Fit, ...]
    noise_level_m: float
    undetected: tuple[Undetected, ...]
    scores: tuple[tuple[str, int | None, float], ...]
    needed: float

    @property
    def fullest(self) -> tuple[Motion, Fit]:
        """The fit with all that is too weak to be named, and the tracks it was made on."""
        last = self.undetected[-1] if self.undetected else None
        return (self.motion, self.best) if last is None else (last.motion, last.attempt.fit)


def calibrated(motion: Motion, base: Fit) -> tuple[Motion, Fit]:
    """Noise from repeats about a fit, and the fit with it."""
    noise, _ = window_noise(motion.tracks, residuals(motion.tracks, base.predictions))
    motion = replace(motion, noise=noise, sizes=None)
    return motion, fit(motion, base.model, list(base.effects), base.coordinates, TO_THE_END)


def select(motion: Motion, model: Model, retrack: Retrack, say: Progress, rule: Rule = FIRST_ORDER) -> Selection:
    """From eps alone. `retrack` makes the tracks again about the chosen model: its own mesh error."""
    motion, null = calibrated(motion, fit_eps(motion, model))
    now = stated(motion, null, rule)
    null = now.fit
    undetected: tuple[Undetected, ...] = ()
    rival: Try | None = None  # what else might have come first
    scores: tuple[tuple[str, int | None, float], ...] = ()
    asked = 0.0
    for level in range(AT_MOST):
        say(f"looking for effect {level + 1}")
        doubted = score(now.motion, now.fit)
        scores = scores or tuple((e.name, e.place, s) for e, s, _ in doubted.ranked)
        needed = max(np.log(ODDS), doubted.on_nothing)
        asked = asked or needed
        tries = proposals(now, doubted, needed, level)
        if rival is not None and unclear(now.motion, now.fit):
            tries += beside(now.motion, rival, FULL_FITS[level])
        if not rule.repeated:
            needed = max(needed, 0.5 * rule.needed(now.fit, -2 * now.score, 0.0))
            # nothing is predicted better than what is fitted
            tries = [t for t in tries if -0.5 * t.fit.chi2 > now.score + needed]
        tries, judged = weighed(now.motion, tries, rule)
        order = sorted(range(len(tries)), key=lambda i: -judged[i].score)
        order = [i for i in order if judged[i].score > now.score + needed]
        if not order:
            break
        first, better = tries[order[0]], judged[order[0]]
        others = [tries[i] for i in order if tries[i].added.name != first.added.name and not now.fit.effects]
        rival = others[0] if others else None
        extended = stated(*calibrated(replace(motion, tracks=retrack(better.fit.model)), better.fit), rule)
        noise_level = path_noise(extended.motion, extended.fit.predictions)  # repeats differ by what is missing, too
        chosen = Try(extended.fit, first.added, trace_of(extended, first.added))
        if chosen.strength_m < VISIBLE * noise_level:
            undetected = (Undetected(chosen, extended.motion),)
            break
        now = pruned(extended, needed, rule)
        motion = replace(now.motion, sizes=None)
        null = fit(now.motion, null.model, [], null.coordinates)
        if not any(e.key == first.added.key for e in now.fit.effects):
            break
    now, null, bases, lost = visible(now, null, rule)
    noise_level = path_noise(now.motion, now.fit.predictions)
    return Selection(now.motion, null, now.fit, bases, noise_level, (*lost, *undetected), scores, asked)


def stated(motion: Motion, found: Fit, rule: Rule) -> Explanation:
    """A fit as an explanation; where nothing is repeated and parts are held out, scored by what it predicts of these.

    A single recording cannot tell what its model misses all the time from discrepancy.
    """
    if rule.repeated:
        return explained(motion, found)
    return Explanation(motion, found, -0.5 * rule.held_out(motion, found))


def weighed(motion: Motion, tries: Sequence[Try], rule: Rule) -> tuple[list[Try], list[Explanation]]:
    """Tries as explanations: the best of them fitted again under their own discrepancy."""
    if not rule.repeated:
        return list(tries), [stated(motion, t.fit, rule) for t in tries]
    quick = in_processes([(explained, (motion, t.fit, 0, 1)) for t in tries])
    order = sorted(range(len(tries)), key=lambda i: -quick[i].score)[:REFITTED]
    return [tries[i] for i in order], in_processes([(explained, (quick[i].motion, quick[i].fit)) for i in order])


def promising(ranked: Sequence[Ranked], needed: float, count: int) -> list[Ranked]:
    """What earns a full fit: to first order candidates fall short of what they are worth."""
    least = max(PROMISING * needed, SHARE * ranked[0][1]) if ranked else 0.0
    return shortlist([r for r in ranked if r[1] > least], count)


def proposals(now: Explanation, doubted: Scored, needed: float, level: int) -> list[Try]:
    """Full fits of what ranks best where noise alone counts, and of what else does beside the discrepancy."""
    plain = replace(now.motion, sizes=None)
    base = fit_guided(plain, now.fit)
    tries = attempts(plain, base, promising(score(plain, base).ranked, needed, FULL_FITS[level]))
    if not level and min([base.chi2, *(t.fit.chi2 for t in tries)]) > FAR * base.evidence.count.sum():
        tries += attempts(plain, base, from_typical(plain, base))
    if now.motion.sizes is None:
        return tries
    tried = {t.added.key for t in tries}
    others = [r for r in promising(doubted.ranked, needed, DOUBTED) if r[0].key not in tried]
    return tries + attempts(now.motion, now.fit, others, FINALISTS // 2)


def trace_of(e: Explanation, effect: ActiveEffect) -> float:
    """Path RMS [m] that an effect of an explanation is worth."""
    own = next(x for x in e.fit.effects if x.key == effect.key)
    return trace(e.motion, e.fit, fit_without(e.motion, e.fit, own), own)


def detection(motion: Motion, found: Fit, rule: Rule) -> float:
    """Path RMS [m] that a name must be worth: the noise level, and no less than what no name accounts for.

    Steps across gaps of all markers are no law's.
    """
    noise_level = path_noise(motion, found.predictions)
    missed = path_error(motion, found.predictions, mend=True) ** 2 - noise_level**2 if rule.repeated else 0.0
    return float(np.sqrt(max(noise_level**2, missed)))


def visible(
    now: Explanation, null: Fit, rule: Rule
) -> tuple[Explanation, Fit, tuple[Fit, ...], tuple[Undetected, ...]]:
    """Without effects whose trace is below detection, the weakest first; null and the fits without each of the others,
    under the discrepancy of what is left."""
    lost: list[Undetected] = []
    while True:
        motion, best = now.motion, now.fit
        bases = (null,) if len(best.effects) == 1 else each_without(motion, best)
        traces = [trace(motion, best, b, e) for e, b in zip(best.effects, bases, strict=True)]
        least = detection(motion, best, rule)
        if all(t >= least for t in traces):
            return now, null, bases, tuple(lost[::-1])
        weakest = int(np.argmin(traces))
        lost.append(Undetected(Try(best, best.effects[weakest], traces[weakest]), motion))
        now = stated(motion, fit_guided(motion, bases[weakest], TO_THE_END), rule)
        null = fit(now.motion, null.model, [], null.coordinates)


def unclear(motion: Motion, found: Fit) -> bool:
    """Whether windows are left with much more than chance."""
    left = np.concatenate(
        [
            x / motion.noise.of(t)
            for t, x in zip(motion.tracks, residuals(motion.tracks, found.predictions), strict=True)
        ]
    )
    return bool(np.nanmean(left**2) > UNCLEAR)


def trace(motion: Motion, full: Fit, base: Fit, effect: ActiveEffect) -> float:
    """Path RMS [m] that `effect` of a fit is worth: against the fit without it.

    Where eps is known, and nearer to that with the effect, eps is not let run to take its place.
    """
    fitted_again = strength(motion, full.predictions, base.predictions)
    if motion.ratio is None:
        return fitted_again
    near, far = (abs(np.log(f.model.medium.anisotropy_ratio / motion.ratio)) for f in (full, base))
    if near >= far:
        return fitted_again
    return max(fitted_again, strength(motion, full.predictions, predicted_without(motion, full, effect)))


def attempts(motion: Motion, base: Fit, promising: Sequence[Ranked], finalists: int = FINALISTS) -> list[Try]:
    """A few steps for all, and to the end for the best of them."""
    first = in_processes([(attempt, (motion, base, e, x, SCREENING)) for e, _, x in promising])
    first.sort(key=lambda t: t.fit.chi2)
    ahead = [t for t in first[:finalists] if t.fit.chi2 < OUT_OF_REACH * first[0].fit.chi2]
    return in_processes([(finished, (motion, base, t)) for t in ahead])


def beside(motion: Motion, rival: Try, count: int) -> list[Try]:
    """What goes with another first effect: the first choice may have bent itself around a second that was missing."""
    base = fit_guided(motion, rival.fit)
    return attempts(motion, base, shortlist(score(motion, base).ranked, count))


def from_typical(motion: Motion, base: Fit) -> list[Ranked]:
    """Effects without a place or a memory, from moderate values: neutral ones are too far off to tell."""
    barred = motion.untestable | {e.name for e in base.effects}
    absent = (c for c in candidates_of(base) if c.place is None and c.name not in barred)
    typical = [ActiveEffect.typical(c.name) for c in absent if "history" not in getattr(c.effect, "knows", ())]
    return [(e, 0.0, np.concatenate([base.coordinates, e.coordinates[:-1]])) for e in typical]


def finished(motion: Motion, base: Fit, t: Try, steps: int = STEPS) -> Try:
    """Fitted to the end."""
    found = fit_guided(motion, t.fit, steps)
    return Try(found, t.added, trace(motion, found, base, t.added))


def attempt(motion: Motion, base: Fit, added: ActiveEffect, x: np.ndarray, steps: int) -> Try:
    """Fit the base's effects and one more in full; its strength is what the path loses without it."""
    order = [*base.effects, added]
    moved = sorted(range(len(order)), key=lambda i: order[i].name == "frame_drift")
    sizes = [len(e.effect.parameters) for e in order]
    starts = np.cumsum([1, *sizes])
    neutral = np.concatenate([base.coordinates, added.coordinates[:-1]])
    for share in SHARES:
        start = neutral + share * (x - neutral)
        start = np.concatenate([start[:1], *(start[starts[i] : starts[i] + sizes[i]] for i in moved)])
        found = fit(motion, base.model, [order[i] for i in moved], start, steps)
        if found.evidence.count.sum() >= base.evidence.count.sum():
            break
    return Try(found, added, strength(motion, found.predictions, base.predictions))


def each_without(motion: Motion, best: Fit) -> tuple[Fit, ...]:
    """Fits without each of the effects."""
    return tuple(in_processes([(fit_without, (motion, best, e)) for e in best.effects]))


def pruned(now: Explanation, needed: float, rule: Rule) -> Explanation:
    """Without effects that no longer earn their place."""
    if len(now.fit.effects) < 2:
        return now
    tasks = [(stated, (now.motion, f, rule)) for f in each_without(now.motion, now.fit)]
    without = in_processes(tasks) if rule.repeated else [run(*given) for run, given in tasks]
    best = max(without, key=lambda e: e.score)
    return now if now.score - best.score > needed else pruned(best, needed, rule)
