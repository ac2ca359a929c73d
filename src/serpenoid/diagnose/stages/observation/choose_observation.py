"""Which effects the markers show and the servos do not: zeros, play, markers that are displaced or sway, length scale,
axes of a camera, clock rate."""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import replace

import numpy as np

from serpenoid.diagnose.data.cameras.columns import columns_of
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.chance import NORMAL, SYSTEMATIC
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR, far_less, lawful
from serpenoid.diagnose.inference.fits.finding import VISIBLE, Divided, Named, Rival, Stage, alone, excludable, interval
from serpenoid.diagnose.inference.fits.prices import Priced, cheapest, earned, most_gained, outweighed
from serpenoid.diagnose.stages.observation.clock_rates import rate_of_all, rates_by_trial
from serpenoid.diagnose.stages.observation.looked import Key, Looked, effect_of, gained_beyond
from serpenoid.diagnose.stages.observation.marker_evidence import (
    along,
    apart,
    beside_readings,
    by_trial,
    misfit_beside,
    sample,
    structure_by_trial,
)
from serpenoid.diagnose.stages.observation.seen_by_trial import slipping
from serpenoid.diagnose.stages.observation.told_lengths import instead_of_effects
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.catalogue import find
from serpenoid.files.store import remembered

FULL_FITS = 6
FIRST_ORDER = 0.02  # of what an effect explains: what linear scores fall short by
RIDES = "the marker at vertex {vertex} rides on neither link there: it moves as the joint bends"


@remembered
def choose_observation(
    recordings: Sequence[Recording],
    now: Observation,
    without: Set[str] = frozenset(),
    before: tuple[float, ...] = (),
    rate: tuple[float, float] = (0.0, 0.0),
) -> tuple[Stage, Observation]:
    """What is new beside the observation model `now`, and the model to be taken out of the data (weak effects too).

    without: effects that are no candidates. before: what a reference left, which is no news (`Stage.squares`). rate: of
    the clocks, as it is known [s/s], and its deviation.
    """
    bare = best = Looked(sample(recordings), now, now, without=frozenset(without))
    while (more := _next(best)) is not None:
        best = more
        if best.size > 1 and best.strength(best.keys[-1]) < VISIBLE:  # the first may be the lesser part of one cause
            break
    best = earned(best, bare, Looked.each_without, lambda f: np.inf if _another(bare, f) else f.needed)
    best = _beside_play(best, before)
    best, refused = lawful(best, _effects, _law_error, Looked.without_one)
    whole = _left_over(best, before)
    if whole[-1] is not None:  # what the whole body shares in all trials may only mend that
        best, more_refused = lawful(best, _effects, _law_error, Looked.without_one, shared=LAW_ERROR)
        refused += more_refused
        whole = _left_over(best, before)
    *_, news, sides = whole
    slips = None
    if any(news) and not (sides and sides.changed):  # which of a marker, a horn, or the scale: one channel does not say
        best, slips = slipping(recordings, best, FULL_FITS)
    beyond = _beyond_bounds(best)
    other = instead_of_effects(best)
    kept = best.keys if other is None else other.beside.keys
    fits = [(best if other is None or key not in kept else other.beside, key) for key in best.keys]
    every = [_named(fit, key, stand_in=key not in kept) for fit, key in fits if key not in beyond]
    rates = rates_by_trial(recordings, best)
    clock = rate_of_all(recordings, best, rate) if rates is None else None
    every += [] if clock is None else [clock]
    nameless = [n for n in every if n.strength >= VISIBLE and n.may_change_nothing]
    every = [n for n in every if n not in nameless]
    named, torn = _torn([n for n in every if n.strength >= VISIBLE])
    undetected = tuple(n for n in every if n.strength < VISIBLE)
    rivals = tuple(r for k in best.keys if k in {n.effect.key for n in named} for r in rivals_of(best, k))
    left, words, squares, new, divided = whole if slips is None else _left_over(best, before)
    if slips is not None and words:
        words, divided = (words[0], slips.divided.words), slips.divided
        refused = slips.told.of_others(refused)
    if rates is not None:
        words, divided = (rates.words, *words), rates
    mend = other if any(n.stand_in for n in named) else None
    words += () if mend is None else (mend.words,)
    unknown = (f"{n.effect.called} is not named: its values may be anything" for n in nameless)
    words = (*words, *beyond.values(), *unknown, *(RIDES.format(vertex=k) for k in torn), *refused)
    first = "" if mend is None else mend.remedy
    said = Stage("observation", named, rivals, undetected, left, words, squares=squares, news=new, mend=first)
    return replace(said, divided=divided, each=() if slips is None else slips.models), best.now


def _effects(found: Looked) -> list[ActiveEffect]:
    """With their values."""
    return [effect_of(found, key) for key in found.keys]


def _another(bare: Looked, best: Looked) -> bool:
    """Whether what is left is an error of another kind: more than is taken away, and of what the whole body shares also
    more of what lasts from frame to frame. Readings that are rounded leave much that does not."""
    if not outweighed(bare.priced, best.priced):
        return False
    lasts = best.structure.sum()
    done = sum(float((best.signature(k)[:-1] ** 2).sum()) for k in best.keys)  # as of `structure`, paths apart
    return any(place is not None for _, place in best.keys) or bool(lasts >= done)


def _torn(named: Sequence[Named]) -> tuple[tuple[Named, ...], list[int]]:
    """Names, and vertices whose marker is beside its place on the link behind and on the one ahead at once: it rides on
    one link, so that the two are there for another law of that marker."""
    at = {mark: {n.effect.place for n in named if n.effect.effect.marks == mark} for mark in ("markers", "ahead")}
    torn = at["markers"] & at["ahead"]
    marked = (n.effect.effect.marks in at and n.effect.place in torn for n in named)
    doubted = tuple(replace(n, stand_in=n.stand_in or m) for n, m in zip(named, marked, strict=True))
    return doubted, sorted(place for place in torn if place is not None)


def _beyond_bounds(best: Looked) -> dict[Key, str]:
    """Effects that the data push beyond their bounds by more than chance, and what is said of them: they are taken out
    of the data, and no findings."""
    said = {}
    for i, key in enumerate(best.keys):
        if gained_beyond(best, key) > best.needed:
            share = 1 - best.priced.chi2 / best.without_one(i).priced.chi2
            name = effect_of(best, key).called
            said[key] = f"{name} takes away {share:.0%} of what is left, but is pushed beyond its bound: not named"
    return said


def _beside_play(best: Looked, before: tuple[float, ...]) -> Looked:
    """Without effects that only mend what the law of another one's joint leaves: they must take away enough where the
    other joints that have play are free, too."""
    while best.size > 1 and _left_over(best, before)[1]:
        gains, loose = [], [k for k in best.keys if find(k[0]).marks == "gaps"]
        for i, key in enumerate(best.keys):
            others = [j for j in map(_joint, loose) if j is not None and j != _joint(key)]
            rest = best.without_one(i).now
            gains.append(misfit_beside(best.data, rest, others) - misfit_beside(best.data, best.now, others))
        least = int(np.argmin(gains))
        if gains[least] > best.needed:
            break
        best = best.without_one(least)
    return best


def _law_error(best: Looked, effect: ActiveEffect) -> float:
    """What markers are off by in the direction in which an effect moves them, beyond noise and as much again, over what
    it does; 0 of one that is below detection."""
    if best.strength(effect.key) < VISIBLE:
        return 0.0
    left, done = along(best.data, best.now, columns_of(best.data.body, *effect.key), best.changed_by(effect.key))
    return float(np.sqrt(left / max(done, 1e-12)))


def _joint(key: Key) -> int | None:
    """Which joint's angle an effect changes."""
    name, place = key
    return place - 1 if place is not None and find(name).place == "joint" else None


def _left_over(
    best: Looked, before: tuple[float, ...]
) -> tuple[float, tuple[str, ...], tuple[float, ...], tuple[float, ...], Divided | None]:
    """Of the worst channel, its noise included, what is more than chance makes; that in words, where visible beside
    what was left before; mean squares of all channels and of all together; `Stage.news`; and trials in which the
    channel is another."""
    squares, all_squares = best.structure, best.priced.spread**2
    known = np.array(before) if len(before) == len(squares) + 1 else np.zeros(len(squares) + 1)
    known = np.maximum(known, 1.0)  # the noise itself, which a little of structure is in
    news = squares / known[:-1]
    worst = int(news.argmax())
    size = float(np.sqrt(squares[worst]))
    joints = best.data.body.joint_count
    what = f"joint {worst + 1} bent" if worst < joints else f"the edge from vertex {worst - joints} as long"
    words: tuple[str, ...] = ()
    divided = None
    if news[worst] > 1 + VISIBLE**2:
        words = (f"markers do not show {what} as it should be: {size:.1f} times the noise",)
    if words:
        divided = _from_trial_to_trial(best, worst)
        words += () if divided is None else (divided.words,)
    if not words and all_squares > known[-1] * (1 + VISIBLE**2):  # nothing that lasts from frame to frame
        beyond = beside_readings(best.data, best.now)
        if beyond > 1 + VISIBLE**2:
            words = (f"markers are off by {np.sqrt(beyond):.1f} times the noise of most frames, now here, now there: "
                     "look for reflections and mistaken matches in single frames, or joints that jump between two "
                     "readings of the log",)  # fmt: skip
    share = np.where(news > 1 + VISIBLE**2, np.sqrt(1 - 1 / np.maximum(news, 1.0)), 0.0)
    return float(np.hypot(1.0, size)), words, (*squares.tolist(), all_squares), tuple(share.tolist()), divided


def _from_trial_to_trial(best: Looked, channel: int) -> Divided | None:
    """Where a joint is bent by one angle in some trials and by another in others, or an edge is so long: when it
    changed most. Trials before and since are two sides if, on each, values are about one."""
    values, about = by_trial(best.data, best.channels_left, channel)
    known = np.flatnonzero(np.isfinite(values))
    if len(known) < 2:
        return None
    if about > LAW_ERROR**2:
        return _in_some_trials(best, channel)
    changes = np.diff(values[known])
    at = int(np.abs(changes).argmax())
    sides = known[: at + 1], known[at + 1 :]
    joints = best.data.body.joint_count
    where, grown = best.data.names[sides[1][0]], float(changes.sum())
    begun, unit = f"joint {channel + 1} is bent by another angle from trial to trial", "rad"
    little, slipped = "its horn may slip a little in each", "its horn, or a marker beside it, may have slipped"
    if channel >= joints:
        begun = f"the edge from vertex {channel - joints} is another length from trial to trial"
        unit, changes, grown = "mm", 1e3 * changes, 1e3 * grown
        little, slipped = (
            "a marker at an end of it may slip a little in each",
            "a marker at an end of it may have slipped",
        )
    if abs(changes[at]) < LAW_ERROR * abs(grown):
        end = f"`{best.data.names[known[0]]}` to `{best.data.names[known[-1]]}`"
        return Divided(f"{begun}, by {grown:+.3g} {unit} in all from {end}: {little}")
    words = f"{begun}, by {changes[at]:+.3g} {unit} at `{where}`: {slipped}"
    before, since = (values[side] for side in sides)
    widest = max(np.abs(x - x.mean()).max() for x in (before, since))
    if widest > LAW_ERROR * abs(since.mean() - before.mean()):
        return Divided(words)
    others, changed = (tuple(best.data.names[i] for i in side) for side in sides)
    return Divided(words, changed, others)


def _in_some_trials(best: Looked, channel: int) -> Divided | None:
    """Where a joint is bent, or an edge as long, as it should be in some trials, and in others not: those leave far
    more, as in `trials_astray`. It may be the gaits that differ, so it is `perhaps`."""
    squares = structure_by_trial(best.data, best.channels_left, channel)
    astray, calm = squares > 1 + VISIBLE**2, squares <= 1 + VISIBLE**2  # neither: of what a trial does not show
    if not calm.any() or not astray.any() or not far_less(squares[calm], squares[astray]):
        return None
    changed, others = (tuple(n for n, x in zip(best.data.names, of, strict=True) if x) for of in (astray, calm))
    joints = best.data.body.joint_count
    what = f"joint {channel + 1}" if channel < joints else f"the edge from vertex {channel - joints}"
    return Divided(f"{what} is not as it should be in {alone(changed, others)}", changed, others, perhaps=True)


def _next(best: Looked) -> Looked | None:
    """With one more effect, or None."""
    own, others = best.own, best.others
    left = [(best.sums.chi2([*own, *columns_of(best.data.body, *k)]), k) for k in others]
    priced = [Priced(chi2, len(own) + len(columns_of(best.data.body, *k)), best.data.count) for chi2, k in left]
    if cheapest(best.priced, priced, len(others)) is None:
        return None
    tries = best.beside_each([k for _, k in sorted(left, key=lambda pair: pair[0])[:FULL_FITS]])
    found = cheapest(best.priced, [t.priced for t in tries], len(others))
    return None if found is None else tries[found]


def rivals_of(best: Looked, key: Key) -> list[Rival]:
    """What else could stand in the place of one chosen effect, the others kept: scored linearly, then fitted."""
    data, body, least = best.data, best.data.body, best.priced
    base = best.without_one(best.keys.index(key))
    band = most_gained(len(columns_of(body, *key)), 1 + len(best.others))
    slack = FIRST_ORDER * (base.priced.chi2 - least.chi2)
    found = []
    for other in best.others:
        columns = [*base.own, *columns_of(body, *other)]
        if excludable(base.sums.chi2(columns), least.chi2, least.count, band, slack):
            continue
        fitted = base.beside(other)
        rival = Rival(effect_of(fitted, other), effect_of(best, key), apart(data, best.now, fitted.now))
        if not excludable(fitted.priced.chi2, least.chi2, least.count, band):
            found.append(rival)
    return found


def _named(best: Looked, key: Key, stand_in: bool) -> Named:
    """Intervals from the curvature, and no less than what gaits disagree about. What the whole body shares, and leaves
    as much of what it does as no effect at a place may (law_error.py), is a stand-in, too."""
    spread = SYSTEMATIC * best.priced.spread
    covariance = best.sums.covariance(best.own, spread)
    effect = effect_of(best, key)
    ends, bound = {}, []
    for p, column in zip(effect.effect.parameters, columns_of(best.data.body, *key), strict=True):
        at = best.own.index(column)
        if effect.parameters[p.name] in (p.lower, p.upper):
            bound.append(p.name)
        half = NORMAL * float(np.sqrt(covariance[at, at])) + p.resolution
        ends[p.name] = interval((effect.parameters[p.name] - half, effect.parameters[p.name] + half))
    partly = effect.place is None and _law_error(best, effect) > LAW_ERROR
    return Named(effect, ends, best.strength(key), tuple(bound), stand_in or partly, best.known(key))
