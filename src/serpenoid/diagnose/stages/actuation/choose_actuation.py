"""Which actuation effects the servos' readings show, joint by joint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from serpenoid.diagnose.data.chance import NORMAL, SYSTEMATIC
from serpenoid.diagnose.data.recordings.clocks import pooled
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR, lawful
from serpenoid.diagnose.inference.fits.finding import VISIBLE, Divided, Named, Rival, Stage, excludable, interval
from serpenoid.diagnose.inference.fits.prices import PLAINLY, earned, most_gained
from serpenoid.diagnose.stages.actuation.actuation_by_joint import Attempt, attempts
from serpenoid.diagnose.stages.actuation.actuation_evidence import slopes_of
from serpenoid.diagnose.stages.actuation.actuation_refit import refined
from serpenoid.diagnose.stages.actuation.actuation_search import Played, each_its_own, next_one, numbers_of, of_all_anew
from serpenoid.diagnose.stages.actuation.displaced_markers import DisplacedMarker, displaced_marker
from serpenoid.diagnose.stages.actuation.gone import as_neutral
from serpenoid.diagnose.stages.actuation.law_by_trial import law_by_trial
from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.diagnose.stages.actuation.trials_astray import trials_astray
from serpenoid.diagnose.stages.by_trial import ByTrial, changes_of_side
from serpenoid.effects.active import ActiveEffect, of_key
from serpenoid.effects.base import ActuationEffect
from serpenoid.files.store import remembered
from serpenoid.measure.logs import TICK
from serpenoid.parallel import in_processes

AT_MOST = 7  # effects; two more than joints where these are many: all servos may be weak
DISPLACED = "no servo need be the cause"
AT_REST = 0.1  # of a tick, from one reading to the next


@remembered
def choose_actuation(data: Plays) -> Stage:
    """What readings show; of joints that markers alone show, what they show beside constant bends, too: a zero that is
    off would hide what else is wrong with servos."""
    said: tuple[str, ...] = ()
    stage, best = _chosen(data)
    left = stage.left
    for _ in range(data.readings.shape[1]):
        off = _bent_for_good(best)
        if not off.any():
            break
        said += stage.words[:1] + _also_bent(best, off) * (DISPLACED not in stage.words[0])
        stage, best = _chosen(replace(best.data, habit=best.data.habit + off))
    return replace(stage, words=(*said, *stage.words), left=max(left, stage.left))


def _bent_for_good(best: Played) -> np.ndarray:
    """Constants (m,) [rad] by which joints are beyond their commands as markers show them, where nearly all that is
    left of them is that; 0 of the others, and of all where the one that is worst is none of them."""
    data, none = best.data, np.zeros(best.data.readings.shape[1])
    if data.recordings[0].by_servos:
        return none
    squares = data.structure(best.angles)
    off = data.left(best.angles).sum(axis=0) / data.often
    nearly = (squares > VISIBLE**2) & (off**2 >= (1 - LAW_ERROR**2) * squares * data.held_against**2)
    return np.where(nearly, off, 0.0) if nearly[squares.argmax()] else none


def _also_bent(best: Played, off: np.ndarray) -> tuple[str, ...]:
    """Words on such joints but for the one that is worst."""
    squares = best.data.structure(best.angles)
    others = [j for j in np.flatnonzero(off) if j != squares.argmax()]
    return tuple(_unlike(best, int(j), float(np.sqrt(1 + squares[j]))) for j in others)


def _chosen(data: Plays) -> tuple[Stage, Played]:
    """Forward selection; what does not earn its name is dropped, what is too weak is listed."""
    bare = best = Played(data)
    singles: list[Attempt] = []
    for _ in range(max(AT_MOST, data.readings.shape[1] + 2)):
        if best.followed and (best.effects or data.recordings[0].by_servos):
            break
        tries = attempts(data, best.effects)
        singles = singles or tries
        grown = next_one(best, tries)
        if grown is None:
            break
        new, best = grown
        if data.strength(new) < VISIBLE:
            break
        if new.place is None and not best.followed:  # before what it leaves looks like faults of joints
            best = of_all_anew(best)
    best = each_its_own(of_all_anew(Played(data, refined(data, best.effects))))
    best = _exchanged(_earned(best, bare), best, bare)
    earlier = best
    best, refused = lawful(best, lambda found: list(found.effects), _law_error, _without)
    squares = data.structure(best.angles)
    worst, left = int(squares.argmax()), float(np.sqrt(1 + squares.max()))
    every = beside_a_larger(data, [as_neutral(best, _named(best, e)) for e in best.effects])
    misses = squares[worst] > VISIBLE**2
    doubted = misses or any(n.stand_in for n in every)
    by_trial = _by_trial(best, earlier) if doubted else None
    divided = _divided(best, bare, worst, by_trial) if doubted else None
    words: tuple[str, ...] = (_unlike(best, worst, left),) if misses else ()
    words += () if divided is None else (divided.words,)
    some = divided is not None and divided.changed  # a law that acts in these alone leaves much where it acts in all
    if by_trial is not None and divided is not None and divided in by_trial.said:  # it is their law
        refused = by_trial.of_others(refused)
    words += refused if misses and not some else ()
    marker = _displaced(best, worst) if misses else None
    if marker is not None:  # a law of a servo there may only mend what it does
        every = [n for n in every if n.effect.place is None or not marker.beside(n.effect.place)]
    named = tuple(n for n in every if n.strength >= VISIBLE and not n.may_change_nothing)
    undetected = tuple(n for n in every if n not in named)
    rivals = tuple(r for n in named for r in _rivals(best, n.effect, singles))
    mend = "" if marker is None else marker.remedy
    return Stage("actuation", named, rivals, undetected, left, words, divided=divided, mend=mend), best


def _exchanged(best: Played, grown: Played, bare: Played) -> Played:
    """With other laws of all servos in the place of those that are left, if that is likelier, where some that were
    found beside them (`grown`) were not kept: these may have bent the others to themselves."""
    kept, found = ({e.name for e in of.effects if e.place is None} for of in (best, grown))
    if not kept or not found - kept:
        return best
    again = of_all_anew(best, found - kept)
    return best if again is best else _earned(again, bare)


def _earned(best: Played, bare: Played) -> Played:
    """Without what does not earn its name."""
    return earned(best, bare, _each_without, lambda found: found.needed)


def beside_a_larger(data: Plays, every: Sequence[Named]) -> list[Named]:
    """Names; with a reference in which a law of servos missed more than noise, one of all servos beside a larger change
    is perhaps a stand-in: a body that moves otherwise loads all of them otherwise, and what the law missed of that is
    no news."""
    wrong = bool(np.median(data.unsure / data.noise) > VISIBLE)
    most = max((n.strength for n in every), default=0.0)
    return [replace(n, stand_in=n.stand_in or (wrong and n.effect.place is None and n.strength < most)) for n in every]


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
    by_law = None if law is None else law.said[-1]
    found, told = (trials_astray(best.data, of.angles, joint) for of in (best, bare))
    if told is None or not told.changed:
        return by_law if found is None else found
    if found is not None and found.changed and (found.changed == told.changed or _fewer_moments(best, found, told)):
        return found
    return replace(told, perhaps=True)


def _fewer_moments(best: Played, one: Divided, other: Divided) -> bool:
    """Whether one way to divide trials, in the order in which they were played, changes sides less often."""
    names = [r.name for r in best.data.recordings]
    return changes_of_side(one.changed, names) < changes_of_side(other.changed, names)


def _unlike(best: Played, joint: int, left: float) -> str:
    """That a joint (0 .. m - 1) is so many times the noise from what it is told, or what shows it so."""
    marker = _displaced(best, joint)
    if marker is None:
        return f"joint {joint + 1} misses its command by {left:.1f} times {_missed(best, joint)}"
    return (
        f"the bend that markers show at joint {joint + 1} is off its command by {left:.1f} times its noise, and "
        f"{DISPLACED}: {marker.words}"
    )


def _displaced(best: Played, joint: int) -> DisplacedMarker | None:
    """The marker that makes a joint (0 .. m - 1) seem to miss its command, where no servo log says that it does."""
    recordings = best.data.recordings
    return None if recordings[0].by_servos else displaced_marker(recordings, joint + 1)


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
    kept = [e for e in best.effects if e.key != effect.key]
    tries = [t for t in (attempts(data, kept) if kept else singles) if numbers_of(t.effect) <= numbers_of(effect)]
    band = most_gained(numbers_of(effect), len(tries))
    roughly = min(float(t.chi2.sum()) for t in tries)  # each with the shifts in time of all joints' fits together
    close = [t.effect for t in tries if not excludable(float(t.chi2.sum()), roughly, least.count, band)]
    found = []
    for other in (Played(data, (*kept, e)) for e in close if e.key not in keys):
        apart = float((np.sqrt(((other.angles - best.angles) ** 2).mean(axis=0)) / data.level).max())
        rival = Rival(other.effects[-1], effect, apart)
        found += [] if excludable(other.priced.chi2, least.chi2, least.count, band) else [rival]
    return found


def _each_without(best: Played, some: Sequence[int]) -> list[Played | None]:
    """Without each of some effects, by index; None of one that to first order takes away far more than is needed."""
    plain = [worth > PLAINLY * best.needed for worth in best.worth(some)]
    asked = [i for i, cause in zip(some, plain, strict=True) if not cause]
    found = iter(in_processes([(refined, (best.data, _others(best, i), best.effects[i])) for i in asked]))
    return [None if cause else Played(best.data, next(found)) for cause in plain]


def _without(best: Played, index: int) -> Played:
    return Played(best.data, refined(best.data, _others(best, index), best.effects[index]))


def _others(best: Played, index: int) -> list[ActiveEffect]:
    return [e for i, e in enumerate(best.effects) if i != index]


def _named(best: Played, effect: ActiveEffect) -> Named:
    data, parameters = best.data, effect.effect.parameters
    slopes, _ = slopes_of(data, best.effects, effect, best.angles)
    matrix = np.einsum("irm,jrm->ij", slopes, slopes)
    own = np.sqrt(np.maximum(np.diag(matrix), 1e-12))
    inverse = np.linalg.pinv(matrix / np.outer(own, own), hermitian=True) / np.outer(own, own)
    pulls = np.einsum("ij,jrm->irm", inverse, slopes)  # of a reading, on each parameter beside the others
    left, speed = (v / data.noise for v in (data.left(best.angles), data.speed(best.angles)))
    unsure, habit = _unsure(data, speed), _habit_changed(best, effect)
    law, intervals = effect.effect, {}
    if isinstance(law, ActuationEffect) and law.dead_time:
        speed = -slopes[0]  # a start that is open is a delay, jumps and all
    for p, x, pull, chance in zip(parameters, effect.coordinates, pulls, np.diag(inverse), strict=False):
        scores, late = (
            np.array([(pull * v)[data.trials == t].sum() for t in range(len(data.recordings))]) for v in (left, speed)
        )
        timed = isinstance(law, ActuationEffect) and law.needs_seconds and p.unit != "1"
        clock = x * _rate_sd(data) if timed else 0.0
        by_chance = max(float(chance), (scores**2).sum())
        law_error = float((pull**2).sum()) * habit
        sd = np.sqrt(by_chance + ((late * unsure) ** 2).sum() + _rounding(best, pull) + clock**2 + law_error)
        reach = NORMAL * SYSTEMATIC * sd
        intervals[p.name] = interval([p.value(float(v)) for v in (x - reach, x + reach)])
    bound = tuple(p.name for p in parameters if effect.parameters[p.name] in (p.lower, p.upper))
    stand_in = _law_error(best, effect) > 0 or _may_be_any(best, effect)
    known = of_key(data.known, effect.key)
    before = {} if known is None else known.parameters
    return Named(effect, intervals, data.strength(effect), bound, stand_in, before)


def _habit_changed(best: Played, effect: ActiveEffect) -> float:
    """Sum of squares, in units of noise, of what an effect changes of the readings' habitual error: of each joint's the
    share that the effect is of how the joint moves."""
    data, others = best.data, [e for e in best.effects if e.key != effect.key]
    does = np.where(data.read, best.angles - data.realised(others), 0.0)
    moves = np.where(data.read, best.angles - best.angles.mean(axis=0), 0.0)
    share = np.minimum((does**2).sum(axis=0) / np.maximum((moves**2).sum(axis=0), 1e-12), 1.0)  # one that stands still
    return float((data.often * share * (data.unsure / data.noise) ** 2).sum())


def _may_be_any(best: Played, effect: ActiveEffect) -> bool:
    """Whether it is one of several laws of all servos, which together do for many a law that nobody knows, and they
    leave more than chance of most joints."""
    several = effect.place is None and sum(e.place is None for e in best.effects) > 1
    return several and bool(np.median(best.data.structure(best.angles)) > 0)


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
    data, left = best.data, best.data.readings - best.angles
    apart = float(np.median(np.concatenate([np.diff(t) for t in data.times])))
    resting = data.read & (np.abs(data.speed(best.angles)) * apart < AT_REST * TICK)
    ticks = np.round(best.angles / TICK).astype(int)
    ticks -= ticks.min(axis=0)
    total = 0.0
    for j, there in enumerate(resting.T):
        noise = noise_at_rest(left[there, j], ticks[there, j], float(data.noise[j]))
        off = off_by_rounding(np.sqrt(max(noise**2 - TICK**2 / 12, 0.0))) / data.noise[j]
        total += float((np.bincount(ticks[there, j], pull[there, j] * off) ** 2).sum())
    return total


def noise_at_rest(left: np.ndarray, ticks: np.ndarray, noise: float) -> float:
    """Noise [rad] of readings at rest (K,), each about the mean of those at its tick: one that reads the same tick
    again and again has none. noise: what joints that move show, which it is at most."""
    count = np.bincount(ticks)
    alike = len(left) - np.count_nonzero(count)
    if not alike:
        return noise
    mean = np.bincount(ticks, left) / np.maximum(count, 1)
    return min(noise, float(np.sqrt(((left - mean[ticks]) ** 2).sum() / alike)))


def off_by_rounding(noise: float) -> float:
    """RMS [rad] of what the mean of many readings at rest is off by, as they are rounded to ticks with a noise [rad].

    Noise blurs its harmonics (Widrow, IRE Transactions on Circuit Theory 3, 266, 1956); without noise it is the RMS of
    a rounding, TICK / sqrt(12).
    """
    order = np.arange(1, 100)
    return float(TICK / np.pi * np.sqrt((np.exp(-4 * (np.pi * order * noise / TICK) ** 2) / (2 * order**2)).sum()))
