"""Which actuation effects the servos' readings show, joint by joint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from serpenoid.diagnose.data.chance import NORMAL, SYSTEMATIC
from serpenoid.diagnose.data.clocks import pooled
from serpenoid.diagnose.inference.finding import VISIBLE, Divided, Named, Rival, Stage, excludable, interval
from serpenoid.diagnose.inference.law_error import LAW_ERROR, lawful
from serpenoid.diagnose.inference.prices import Priced, cheapest, earned, most_gained
from serpenoid.diagnose.stages.actuation import (
    Attempt,
    attempts,
    fit_everywhere,
    fit_together,
    followed,
    needed,
    slopes_of,
)
from serpenoid.diagnose.stages.displaced_markers import displaced_marker
from serpenoid.diagnose.stages.law_by_trial import ByTrial, law_by_trial
from serpenoid.diagnose.stages.plays import Plays
from serpenoid.diagnose.stages.trials_astray import trials_astray
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import ActuationEffect
from serpenoid.files.store import remembered
from serpenoid.measure.logs import TICK
from serpenoid.parallel import in_processes

AT_MOST = 7  # effects; two more than joints where these are many: all servos may be weak
AT_REST = 0.1  # of a tick, from one reading to the next


@dataclass(frozen=True)
class Played:
    """Some effects of the servos, fitted beside one another."""

    data: Plays
    effects: tuple[ActiveEffect, ...] = ()

    @cached_property
    def angles(self) -> np.ndarray:
        """What servos would read (R, m)."""
        return self.data.realised(self.effects)

    @cached_property
    def priced(self) -> Priced:
        """See `Explanation`."""
        numbers = sum(_numbers(e) for e in self.effects)
        return Priced(float(self.data.chi2(self.angles).sum()), numbers, float(self.data.often.sum()))

    @property
    def size(self) -> int:
        """See `Explanation`."""
        return len(self.effects)


@remembered
def choose_actuation(data: Plays) -> Stage:
    """Forward selection; what does not earn its name is dropped, what is too weak is listed."""
    bare = best = Played(data)
    singles: list[Attempt] = []
    for _ in range(max(AT_MOST, data.readings.shape[1] + 2)):
        if followed(data, best.angles):
            break
        tries = attempts(data, best.effects)
        singles = singles or tries
        size, count = best.priced.parameters, best.priced.count
        one_more = [Priced(float(t.chi2.sum()), size + _numbers(t.effect), count) for t in tries]
        found = cheapest(best.priced, one_more, len(tries))
        if found is None:
            break
        new, best = _one_more(best, [t.effect for t in tries], [p.chi2 for p in one_more], found)
        if _strength(data, new) < VISIBLE:
            break
    best = Played(data, _refined(data, best.effects))
    best = earned(best, bare, _each_without, lambda found: needed(data, found.effects))
    earlier = best
    best, refused = lawful(best, lambda found: list(found.effects), _law_error, _without)
    squares = data.structure(best.angles)
    worst, left = int(squares.argmax()), float(np.sqrt(1 + squares.max()))
    every = [_named(best, e) for e in best.effects]
    misses = squares[worst] > VISIBLE**2
    doubted = misses or any(n.stand_in for n in every)
    divided = _divided(best, bare, worst, _by_trial(best, earlier)) if doubted else None
    words: tuple[str, ...] = (_unlike(best, worst, left),) if misses else ()
    words += () if divided is None else (divided.words,)
    words += refused if misses else ()
    named = tuple(n for n in every if n.strength >= VISIBLE and not n.may_change_nothing)
    undetected = tuple(n for n in every if n not in named)
    rivals = tuple(r for n in named for r in _rivals(best, n.effect, singles))
    return Stage("actuation", named, rivals, undetected, left, words, divided=divided)


def _by_trial(best: Played, earlier: Played) -> ByTrial | None:
    """How a law that is refused, or perhaps a stand-in, differs from trial to trial."""
    kept = {e.key for e in best.effects if _law_error(best, e) <= 0}
    return law_by_trial(best.data, best.effects, [e for e in earlier.effects if e.key not in kept])


def _divided(best: Played, bare: Played, joint: int, law: ByTrial | None) -> Divided | None:
    """Trials in which a joint (0 .. m - 1) strays from what is found of it, or from its command, if that has fewer
    moments or is as good: a law that acts in some trials alone is spread over all of them. law: one that differs from
    trial to trial; where it does so steadily, there are no two sides."""
    if law is not None and law.steady:
        return Divided(law.words)
    found, told = (trials_astray(best.data, of.angles, joint) for of in (best, bare))
    if told is None or not told.changed:
        return Divided(law.words) if found is None and law is not None else found
    if found is not None and found.changed and (found.changed == told.changed or _fewer_moments(best, found, told)):
        return found
    return replace(told, perhaps=True)


def _fewer_moments(best: Played, one: Divided, other: Divided) -> bool:
    """Whether one way to divide trials, in the order in which they were played, changes sides less often."""
    names = [r.name for r in best.data.recordings]
    first, second = (sum((a in d.changed) != (b in d.changed) for a, b in pairwise(names)) for d in (one, other))
    return first < second


def _one_more(
    best: Played, tries: Sequence[ActiveEffect], chi2: Sequence[float], found: int
) -> tuple[ActiveEffect, Played]:
    """The candidate that was found, and all with it, fitted again; or the best of those of fewer numbers, if that is
    then cheaper: candidates are fitted roughly, and one that came less far is no reason for one more number."""
    by_chi2 = sorted(range(len(tries)), key=lambda i: chi2[i], reverse=True)
    kinds = {_numbers(tries[i]): i for i in by_chi2} | {_numbers(tries[found]): found}
    chosen = [tries[i] for size, i in sorted(kinds.items()) if size <= _numbers(tries[found])]
    grown = [Played(best.data, _refined(best.data, [*best.effects, new], new)) for new in chosen]
    cheaper = cheapest(best.priced, [g.priced for g in grown], len(tries)) if len(grown) > 1 else None
    index = len(grown) - 1 if cheaper is None else cheaper
    return chosen[index], grown[index]


def _unlike(best: Played, joint: int, left: float) -> str:
    """That a joint (0 .. m - 1) is so many times the noise from what it is told, or what shows it so."""
    recordings = best.data.recordings
    marker = None if recordings[0].by_servos else displaced_marker(recordings, joint + 1)
    if marker is None:
        return f"joint {joint + 1} misses its command by {left:.1f} times {_missed(best, joint)}"
    return (
        f"the bend that markers show at joint {joint + 1} is off its command by {left:.1f} times its noise, and no "
        f"servo need be the cause: {marker.words}"
    )


def _missed(best: Played, joint: int) -> str:
    """The noise that a joint (0 .. m - 1) is held against, and by what constant it is off where that is nearly all."""
    data, by_servos = best.data, best.data.recordings[0].by_servos
    noise = "the reading's noise" if by_servos else "the noise of the bend that markers show"
    off = float(data.left(best.angles)[:, joint].sum() / data.often[joint])
    beyond = float(data.structure(best.angles)[joint] * data.held_against[joint] ** 2)
    if off**2 < (1 - LAW_ERROR**2) * beyond:
        return noise
    return f"{noise}: it {'reads' if by_servos else 'is bent'} {np.degrees(off):+.1f} degrees beyond its command"


def _law_error(best: Played, effect: ActiveEffect) -> float:
    """What readings are off by, beyond noise and as much again, over what the effect does to them beside the others (a
    second law at a joint may only mend the first one's); of an effect at all joints the median joint's."""
    data, place = best.data, effect.place
    bare = data.realised([e for e in best.effects if e.key != effect.key])
    done = (np.where(data.read, (best.angles - bare) / data.level, 0.0) ** 2).sum(axis=0) / data.often
    missed = np.maximum(data.missed(best.angles) - VISIBLE**2, 0.0)
    errors = np.sqrt(missed / np.maximum(done, 1e-12))
    return float(np.median(errors)) if place is None else float(errors[place - 1])


def _rivals(best: Played, effect: ActiveEffect, singles: list[Attempt]) -> list[Rival]:
    """What else could stand in the place of one chosen effect, the others kept; S_ab: the worst joint's RMS.

    A law of more numbers may hold the chosen one as a limit: it is no rival, since its numbers do not earn their price.
    """
    data, least, keys = best.data, best.priced, {e.key for e in best.effects}
    kept = [e for e in best.effects if e is not effect]
    tries = [t for t in (attempts(data, kept) if kept else singles) if _numbers(t.effect) <= _numbers(effect)]
    band = most_gained(_numbers(effect), len(tries))
    roughly = min(float(t.chi2.sum()) for t in tries)  # each with the shifts in time of all joints' fits together
    close = [t.effect for t in tries if not excludable(float(t.chi2.sum()), roughly, least.count, band)]
    found = []
    for other in (Played(data, (*kept, e)) for e in close if e.key not in keys):
        apart = float((np.sqrt(((other.angles - best.angles) ** 2).mean(axis=0)) / data.level).max())
        rival = Rival(other.effects[-1], effect, apart)
        found += [] if excludable(other.priced.chi2, least.chi2, least.count, band) else [rival]
    return found


def _each_without(best: Played) -> list[Played]:
    tasks = [(_refined, (best.data, [e for e in best.effects if e is not out], out)) for out in best.effects]
    return [Played(best.data, effects) for effects in in_processes(tasks)]


def _without(best: Played, index: int) -> Played:
    kept = [e for i, e in enumerate(best.effects) if i != index]
    return Played(best.data, _refined(best.data, kept, best.effects[index]))


def _refined(data: Plays, chosen: Sequence[ActiveEffect], new: ActiveEffect | None = None) -> tuple[ActiveEffect, ...]:
    """Fit each given the others, at its own joint alone, twice round. new: what came to them, or left them, just now;
    those at other joints stay as they are: no joint touches another, but by when a trial began. Where nothing says when
    that was, all are fitted together."""
    chosen = list(chosen)
    if chosen and not all(data.begun(r) for r in data.recordings):
        return fit_together(data, chosen)
    touched = {e.place for e in chosen} if new is None or new.place is None else {None, new.place}
    for _ in range(2):
        for i, effect in enumerate(chosen):
            if effect.place not in touched:
                continue
            others = [e for e in chosen if e is not effect]
            start = np.tile(np.array(effect.coordinates[:-1])[:, None], (1, data.readings.shape[1]))
            (alone,) = fit_everywhere(data, effect.name, others, [start], effect.place)
            chosen[i] = alone.effect
    return tuple(chosen)


def _named(best: Played, effect: ActiveEffect) -> Named:
    data, parameters = best.data, effect.effect.parameters
    slopes, _ = slopes_of(data, best.effects, effect, best.angles)
    matrix = np.einsum("irm,jrm->ij", slopes, slopes)
    own = np.sqrt(np.maximum(np.diag(matrix), 1e-12))
    inverse = np.linalg.pinv(matrix / np.outer(own, own), hermitian=True) / np.outer(own, own)
    pulls = np.einsum("ij,jrm->irm", inverse, slopes)  # of a reading, on each parameter beside the others
    left, speed = (v / data.noise for v in (data.left(best.angles), data.speed(best.angles)))
    unsure = _unsure(data, speed)
    law, intervals = effect.effect, {}
    for p, x, pull, chance in zip(parameters, effect.coordinates, pulls, np.diag(inverse), strict=False):
        scores, late = (
            np.array([(pull * v)[data.trials == t].sum() for t in range(len(data.recordings))]) for v in (left, speed)
        )
        timed = isinstance(law, ActuationEffect) and law.needs_seconds and p.unit != "1"
        clock = x * _rate_sd(data) if timed else 0.0
        by_chance = max(float(chance), (scores**2).sum())
        sd = np.sqrt(by_chance + ((late * unsure) ** 2).sum() + _rounding(best, pull) + clock**2)
        reach = NORMAL * SYSTEMATIC * sd
        intervals[p.name] = interval([p.value(float(v)) for v in (x - reach, x + reach)])
    bound = tuple(p.name for p in parameters if effect.parameters[p.name] in (p.lower, p.upper))
    stand_in = _law_error(best, effect) > 0
    return Named(effect, intervals, _strength(data, effect), bound, stand_in)


def _numbers(effect: ActiveEffect) -> int:
    return len(effect.effect.parameters)


def _rate_sd(data: Plays) -> float:
    """How well the readings' seconds are known as seconds of the film: readings fit each other in any."""
    told = [r.clock for r in data.recordings if r.clock.rate_sd > 0]
    return pooled(told)[1] if told else 0.0


def _unsure(data: Plays, speed: np.ndarray) -> np.ndarray:
    """Standard deviation [s] of each trial's beginning: by a log's labels and commands, which a law of rows that jump
    may take a part of; without any, as readings show it by their rates (R, m) in units of noise."""
    by_rates = [float((speed[data.trials == t] ** 2).sum()) for t in range(len(data.recordings))]
    shown = 1 / np.sqrt(np.maximum(by_rates, 1e-12))
    known, most = (np.array([f(r) for r in data.recordings]) for f in (data.said, data.unsure_start))
    return np.where(known, most / np.sqrt(3), shown)


def _rounding(best: Played, pull: np.ndarray) -> float:
    """Variance of a sum over readings (R, m), in units of noise, by what rounding to ticks does to joints at rest."""
    data = best.data
    off = off_by_rounding(np.sqrt(np.maximum(data.noise**2 - TICK**2 / 12, 0.0))) / data.noise
    apart = float(np.median(np.concatenate([np.diff(t) for t in data.times])))
    resting = np.abs(data.speed(best.angles)) * apart < AT_REST * TICK
    ticks = np.round(best.angles / TICK).astype(int)
    total = 0.0
    for j, there in enumerate(resting.T):
        shared = np.bincount(ticks[there, j] - ticks[:, j].min(), pull[there, j] * off[j])
        total += float((shared**2).sum())
    return total


def off_by_rounding(noise: np.ndarray) -> np.ndarray:
    """RMS [rad] of what the mean of many readings at rest is off by, as they are rounded to ticks with a noise [rad].

    Noise blurs it; of its harmonics the first is the largest (Widrow, IRE Transactions on Circuit Theory 3, 266, 1956).
    """
    return TICK / (np.pi * np.sqrt(2)) * np.exp(-2 * (np.pi * noise / TICK) ** 2)


def _strength(data: Plays, effect: ActiveEffect) -> float:
    """RMS of what the effect alone changes at the worst joint, over the noise."""
    alone = data.realised([effect]) - data.realised([])
    return float((np.sqrt((alone**2).mean(axis=0)) / data.level).max())
