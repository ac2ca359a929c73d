"""First stage: what was commanded against what the servos read, joint by joint.

Every actuation effect that the reading shows is a law from set-point to angle, played by the same code that simulates
it. Joints do not touch each other here, so one evaluation fits an effect at every joint at once.

Legend: R log rows of all trials, m joints, P parameters of an effect, K places.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.recording import Recording, held_out_labels
from serpenoid.diagnose.inference.evidence import Evidence
from serpenoid.diagnose.inference.finding import VISIBLE
from serpenoid.diagnose.inference.medium import CONVERGED
from serpenoid.diagnose.inference.null import Scored, largest_by_chance
from serpenoid.diagnose.inference.prices import most_gained
from serpenoid.diagnose.stages.plays import Plays
from serpenoid.diagnose.stages.set_points import ways
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import ActuationEffect, Effect, Parameter
from serpenoid.effects.catalogue import actuation_effects, find
from serpenoid.files.store import remembered
from serpenoid.parallel import in_processes

STEPS = 7
ROUGHLY = 20  # steps of candidates that share all joints: fits go along a valley, one falls where the other rises
HALVINGS = 6  # of an octave: about a hundredth, of a tenth of a second as little as logs leave open
REACH, SHRUNK = 3.0, 0.7  # of a positive scale: by how much more, and less, it is at most after one step
RIDGE = 1e-9  # of a parameter's own slope, where two may do the same
HOPELESS = 1e6  # damping: no step gains anything
CENTRED = np.linspace(0.0, 1.0, 5)  # of a move after which no trial's start, in the mean, explains anything


@dataclass(frozen=True)
class Attempt:
    """An effect fitted at one joint or at all: the effect, chi squared per joint (m,) with it."""

    effect: ActiveEffect
    chi2: Floats


def plays(recordings: Sequence[Recording], held: bool | None = None) -> Plays:
    """Readings beside the set-points that they follow best, as they are or with a law for all servos, told later or
    not; held: whether rows are, where that is known.

    Noise is the least that readings have about any of it: about a smooth course, those of servos that jump scatter
    widely, and a way that is wrong is followed. Laws of several numbers are tried where those of fewer leave something
    of most joints: what one joint does by itself no law of all servos tells.
    """
    every = list(ways(recordings, held))
    noise = np.min([data.noise for data in every], axis=0)
    every = [replace(data, noise=noise) for data in every]
    few, *sets = _by_numbers(shown(every[0]))
    found = [(data, played) for data, played in zip(every, _by_each(every, few), strict=True)]
    for laws in sets:
        for data, played in found:
            if any(np.median(of.missed(p)) < VISIBLE**2 for of, known in found for p in known):
                break
            played += _by_each([data], laws)[0]
    if len(found) > 1:
        noise = np.min([data.measured(p).noise for data, played in found for p in played], axis=0)
        found = [(replace(data, noise=noise), played) for data, played in found]
    return _measured(*_simplest(found))


def _by_numbers(kinds: Sequence[ActuationEffect]) -> list[list[tuple[str, ...]]]:
    """Laws of all servos, by name, each also beside a dead time: that of no and one number first, then those of more.
    Rows that jump are late beside rows that run, so that it is a matter of time which of them servos follow."""
    laws = [k for k in kinds if k.place is None]
    late = [k for k in laws if k.dead_time]
    sets = [(), *((k,) for k in laws), *((k, law) for k in late for law in laws if not law.dead_time)]
    by_numbers: dict[int, list[tuple[str, ...]]] = {}
    for s in sets:
        by_numbers.setdefault(max(sum(len(k.parameters) for k in s), 1), []).append(tuple(k.name for k in s))
    return [by_numbers[n] for n in sorted(by_numbers)]


def _by_each(every: Sequence[Plays], laws: Sequence[tuple[str, ...]]) -> list[list[Floats]]:
    """What servos play with each of some sets of laws, in each way to take set-points."""
    played = in_processes([(_by_all, (data, names)) for data in every for names in laws])
    return [played[n * len(laws) : (n + 1) * len(laws)] for n in range(len(every))]


def _simplest(found: Sequence[tuple[Plays, list[Floats]]]) -> tuple[Plays, list[Floats]]:
    """The first way in which set-points may be taken, and what servos play in it with each law, that readings do not
    exclude: about noise that is hardly known no way is followed, and what is best may be so by chance."""
    misses = [min(_cost(data, data.alone(p)) for p in played) for data, played in found]
    band = most_gained(1, len(shown(found[0][0])) * len(found))
    return next(way for way, miss in zip(found, misses, strict=True) if miss - min(misses) <= band)


def _cost(data: Plays, played: Floats) -> float:
    """Twice the negative log likelihood of the readings of all joints, but for a constant: where one strays by more
    than noise, what it strays by is its noise, so that a joint that does something else decides nothing."""
    ratio = data.chi2(played) / data.often
    return float((data.often * np.where(ratio > 1, 1 + np.log(np.maximum(ratio, 1.0)), ratio)).sum())


def _measured(data: Plays, every: Sequence[Floats]) -> Plays:
    """With the noise that readings have about whatever all servos may play. Where rows jump, servos that lag are off
    for a reading here and there: that is no smooth law about which readings scatter, nor is it their noise."""
    for played in every:
        data = data.measured(played)
    return data


def _by_all(data: Plays, names: Sequence[str]) -> Floats:
    """What servos play (R, m), as they are told or with laws fitted to all of them."""
    laws = _in_turn(data, (), names)
    return data.realised(fit_together(data, laws, ROUGHLY) if len(laws) > 1 else laws)


def _in_turn(data: Plays, found: Sequence[ActiveEffect], names: Sequence[str]) -> list[ActiveEffect]:
    """Laws of all servos beside what was found, each from where its fits begin beside those before it. A dead time
    comes last: a law that is fitted beside all of one finds nothing left that is late, and no way back."""
    effects, late = list(found), {k.name for k in shown(data) if k.dead_time}
    for name in sorted(names, key=lambda n: n in late):
        kind = next(k for k in shown(data) if k.name == name)
        (law,) = fit_everywhere(data, name, effects, kind.starts(data.readings, data.quickest))
        effects.append(law.effect)
    return effects


def followed(data: Plays, played: Floats) -> bool:
    """Whether what is left of no joint's readings is visible beside their noise."""
    return bool(data.missed(played).max() < VISIBLE**2)


def shown(data: Plays) -> list[ActuationEffect]:
    """Actuation effects that readings show, but for those left out. A dead time is a late start where nothing says when
    trials began."""
    said = all(data.said(r) for r in data.recordings)
    every = (k for k in actuation_effects() if k.shown and k.name not in data.without)
    return [k for k in every if said or not k.dead_time]


def attempts(data: Plays, base: Sequence[ActiveEffect]) -> list[Attempt]:
    """Every actuation effect that readings show, at every joint, beside those in `base`."""
    kinds = [k for k in shown(data) if k.place is not None or all(e.name != k.name for e in base)]
    tasks = [(fit_everywhere, (data, k.name, base, k.starts(data.readings, data.quickest))) for k in kinds]
    return [attempt for found in in_processes(tasks) for attempt in found]


@remembered
def fit_everywhere(
    data: Plays, name: str, base: Sequence[ActiveEffect], starts: Sequence[Floats], only: int | None = None
) -> list[Attempt]:
    """Gauss-Newton for an effect's parameters at every joint, all side by side (once for all without a place), from the
    best of some starts (m,), of several parameters (P, m). only: this joint alone, where it is known when trials began
    (else `fit_together`)."""
    kind = find(name)
    parameters = kind.parameters
    taken = {e.place for e in base if e.name == name}
    places = [p for p in places_of(kind, data) if p not in taken and only in (None, p)]
    if not places:  # every joint has it
        return []
    columns = slice(0, 1) if kind.place is None else np.array([j - 1 for j in places if j is not None])

    without, realised = (data.realised(base), data.realised) if only is None else data.at_joint(only, base)

    def play(x: Floats) -> Floats:
        effects = [ActiveEffect.neutral(name, place).with_coordinates(v) for place, v in zip(places, x.T, strict=True)]
        return realised([*base, *effects])

    def own(by_joint: Floats) -> Floats:
        return by_joint.sum(keepdims=True) if kind.place is None else by_joint[columns]

    begun = [np.atleast_2d(start)[:, columns] for start in starts]
    tried = [own(data.chi2(play(x))) for x in begun] if len(begun) > 1 else [np.zeros(len(places))]
    values = np.choose(np.argmin(tried, axis=0), begun)
    if data.held and any(p.across for p in parameters):
        values = _narrowed(values, lambda x: own(data.chi2(play(x))))
    positive = np.array([p.lower >= 0 for p in parameters]) & (values > 0).all(axis=1)
    small = np.diag([p.small(data.held) for p in parameters])[..., None]
    sizes, near = small.sum(axis=0), 1e-4 * np.array([[abs(p.typical)] for p in parameters])
    best = play(values)
    left, damping = data.left(best), np.ones(len(places))
    for _ in range(STEPS):
        moved = [play(values + step) for step in small]
        slopes = [(left - data.left(x)) / size for x, size in zip(moved, sizes, strict=True)]
        # what is left is at the best moves of clocks, so that only the bare slope turns it into the gradient
        bare = [(x - best) / size for x, size in zip(moved, sizes, strict=True)]
        pull = np.stack([own((left * b).sum(axis=0) / data.noise**2) for b in bare])
        matrix = np.array([[own((s * b).sum(axis=0) / data.noise**2) for s in slopes] for b in bare])
        change = damping * _newton(matrix, pull)
        change = np.where(positive[:, None], _in_reach(change, values), change)
        trial = np.array([[_inside(p, v) for v in row] for p, row in zip(parameters, values + change, strict=True)])
        new = play(trial)
        missed = data.left(new)
        better = own(data.sizes(missed)) < own(data.sizes(left))
        values = np.where(better, trial, values)
        damping = np.where(better, np.minimum(1.0, 2 * damping), damping / 4)
        if better.any():
            best = new if better.all() else play(values)
            left = missed if better.all() else data.left(best)
        if (np.abs(change) < near).all():
            break
    cost, empty, joint = data.sizes(left), data.chi2(without), np.arange(data.readings.shape[1])
    if isinstance(kind, ActuationEffect) and kind.memory:  # a gap that is never crossed may be any wider, and is none
        idle = np.all([play(values + step) == best for step in small], axis=(0, 1))
        cost = np.where(idle, empty, cost)
    by_place = [cost if p is None else np.where(joint == p - 1, cost, empty) for p in places]
    pairs = zip(places, values.T, by_place, strict=True)
    return [Attempt(ActiveEffect.neutral(name, p).with_coordinates(v), total) for p, v, total in pairs]


def _narrowed(values: Floats, cost: Callable[[Floats], Floats]) -> Floats:
    """Coordinates (P, K) by halving steps, of an octave at first: where set-points jump no slope leads there, but the
    nearer they are, the fewer readings lie on the wrong side of a jump."""
    least = cost(values)
    for halving in range(1, HALVINGS + 1):
        for factor in 2.0 ** (0.5**halving * np.array([-1, 1])):
            found = cost(factor * values)
            values, least = np.where(found < least, factor * values, values), np.minimum(found, least)
    return values


def _newton(matrix: Floats, pull: Floats) -> Floats:
    """Changes (P, K) of parameters, by products (P, P, K) of slopes and the pull (P, K); those that do nothing stay."""
    diagonal = np.einsum("ppk->kp", matrix)
    own = np.sqrt(np.maximum(diagonal, 1e-12))
    scaled = np.moveaxis(matrix, -1, 0) / (own[:, :, None] * own[:, None, :])
    scaled[:, range(len(pull)), range(len(pull))] = 1.0 + RIDGE * (len(pull) > 1)
    return np.asarray((np.linalg.solve(scaled, (pull.T / own)[..., None])[..., 0] / own).T)


def _in_reach(change: Floats, values: Floats) -> Floats:
    """Changes of positive scales, no larger than one step may make them."""
    return np.clip(change, -SHRUNK * np.abs(values), REACH * np.abs(values))


def _inside(p: Parameter, coordinate: float) -> float:
    value = min(max(p.value(coordinate), p.lower), p.upper)
    return float(p.coordinate(value)) if np.isfinite(value) else float(coordinate)


@remembered
def fit_together(data: Plays, chosen: Sequence[ActiveEffect], steps: float = np.inf) -> tuple[ActiveEffect, ...]:
    """Levenberg-Marquardt in the parameters of all effects at once, so many steps at most: where nothing says when
    trials began, that depends on what every joint does, and what every other one is fitted to depends on it."""
    parameters = [p for e in chosen for p in e.effect.parameters]
    owner = [e for e in chosen for _ in e.effect.parameters]
    ends = np.cumsum([len(e.effect.parameters) for e in chosen])[:-1]
    small = np.array([p.small(data.held) for p in parameters])
    sets = _side_by_side(owner)

    def at(x: Floats) -> list[ActiveEffect]:
        return [e.with_coordinates(v) for e, v in zip(chosen, np.split(x, ends), strict=True)]

    values, damping = np.array([x for e in chosen for x in e.coordinates[:-1]]), 1e-4
    positive = np.array([p.lower >= 0 for p in parameters]) & (values > 0)
    here, late = data.met(at(values))
    left, taken = data.left(here), 0
    while True:
        cost = float(data.sizes(left).sum())
        moved = [data.begun_at(at(values + np.where(sets == k, small, 0.0)), late) for k in range(sets.max() + 1)]
        change = [_at_place(moved[k] - here, e) for k, e in zip(sets, owner, strict=True)]
        slopes = np.stack([data.slope(here, here + c, x) for c, x in zip(change, small, strict=True)]) / data.noise
        # what is left is at the best moves of clocks, so that only the bare change turns it into the gradient
        pull = np.array([(left * c / data.noise**2).sum() for c in change]) / small
        matrix = np.einsum("irm,jrm->ij", slopes, slopes)
        size = np.sqrt(np.maximum(np.diag(matrix), 1e-12))
        gained = -np.inf
        while gained < 0 and damping < HOPELESS:
            step = np.linalg.solve(matrix / np.outer(size, size) + damping * np.eye(len(size)), pull / size) / size
            step = np.where(positive, _in_reach(step, values), step)
            trial = np.array([_inside(p, v) for p, v in zip(parameters, values + step, strict=True)])
            played, begun = data.met(at(trial))
            missed = data.left(played)
            gained = cost - float(data.sizes(missed).sum())
            damping *= 0.1 if gained >= 0 else 30.0
        if gained < 0:
            return tuple(at(values))
        values, here, late, left, damping = trial, played, begun, missed, max(damping, 1e-9)
        taken += 1
        if gained < CONVERGED * max(1.0, cost / float(data.often.sum())) or taken >= steps:
            return tuple(at(values))


def refined(data: Plays, chosen: Sequence[ActiveEffect], new: ActiveEffect | None = None) -> tuple[ActiveEffect, ...]:
    """Fit each given the others, at its own joint alone, twice round. new: what came to them, or left them, just now;
    those at other joints stay as they are: no joint touches another, but by when a trial began. Where nothing says when
    that was, all are fitted together, and so they are where several laws share all joints."""
    chosen = list(chosen)
    shared = sum(e.place is None for e in chosen) > 1
    if chosen and (shared or not all(data.begun(r) for r in data.recordings)):
        return _told_later(data, fit_together(data, chosen))
    touched = {e.place for e in chosen} if new is None or new.place is None else {None, new.place}
    for _ in range(2):
        for i, effect in enumerate(chosen):
            if effect.place not in touched:
                continue
            others = [e for e in chosen if e is not effect]
            start = np.tile(np.array(effect.coordinates[:-1])[:, None], (1, data.readings.shape[1]))
            (alone,) = fit_everywhere(data, effect.name, others, [start], effect.place)
            chosen[i] = alone.effect
    return _told_later(data, chosen)


def with_laws(data: Plays, found: Sequence[ActiveEffect], names: Sequence[str]) -> tuple[ActiveEffect, ...]:
    """These laws of all servos beside what was found at joints: those that were there, others in turn, and then all
    together."""
    late = {k.name for k in shown(data) if k.dead_time}
    kept = [e for e in found if e.place is not None or e.name in names and e.name not in late]
    return refined(data, _in_turn(data, kept, [n for n in names if all(e.name != n for e in kept)]))


def _told_later(data: Plays, chosen: Sequence[ActiveEffect]) -> tuple[ActiveEffect, ...]:
    """With a dead time about which trials begin when logs say, as far as readings leave that open: each may begin a
    little later, or they are all told later. A start that is open has the variance that it is given in intervals."""
    late = next((e for e in chosen if isinstance(e.effect, ActuationEffect) and e.effect.dead_time), None)
    if late is None:
        return tuple(chosen)
    most = np.array([data.unsure_start(r) for r in data.recordings])
    whole = float(data.later(chosen).mean())
    tried = [tuple(e.moved(0, share * whole) if e is late else e for e in chosen) for share in CENTRED]
    costs = [float(data.chi2(data.realised(t)).sum() + 3 * ((data.later(t) / most) ** 2).sum()) for t in tried]
    return tried[int(np.argmin(costs))]


def _side_by_side(chosen: Sequence[ActiveEffect]) -> np.ndarray:
    """In which set each parameter, by its effect, can be moved at once with the others there: no two of one are at one
    joint."""
    sets: list[set[int | None]] = []
    found = []
    for e in chosen:
        room = (k for k, places in enumerate(sets) if e.place is not None and not places & {None, e.place})
        found.append(next(room, len(sets)))
        if found[-1] == len(sets):
            sets.append(set())
        sets[found[-1]].add(e.place)
    return np.array(found)


def _at_place(change: Floats, effect: ActiveEffect) -> Floats:
    """Of what is read (R, m), at the effect's joint alone; all of it of an effect at all joints."""
    if effect.place is None:
        return change
    own = np.zeros_like(change)
    own[:, effect.place - 1] = change[:, effect.place - 1]
    return own


@remembered
def needed(data: Plays, chosen: Sequence[ActiveEffect]) -> float:
    """Chi squared that an effect must take away: the best of all candidates takes as much of what is left by chance.

    A candidate's column is what its law, where its fit begins, changes of what is played.
    """
    here = data.realised(chosen)
    own = [slope for e in chosen for slope in slopes_of(data, chosen, e, here)[1]]
    everywhere: list[Floats] = []
    at_joint: list[Floats] = []
    for kind in shown(data):
        if kind.place is None and any(e.name == kind.name for e in chosen):
            continue
        columns = [_changed(data, chosen, kind, start, here) for start in kind.starts(data.readings, data.quickest)]
        (everywhere if kind.place is None else at_joint).extend(columns)
    return largest_by_chance([_scored(data, data.left(here) / data.noise, own, everywhere, at_joint)])


def _changed(data: Plays, chosen: Sequence[ActiveEffect], kind: ActuationEffect, start: Floats, here: Floats) -> Floats:
    """What an effect everywhere changes (R, m), in units of noise."""
    places, start = places_of(kind, data), np.atleast_2d(start)
    resting, typical = (np.array([[x] for x in f]) for f in _rests(kind.parameters))
    moderate = np.where(start == resting, typical, start)
    tried = [ActiveEffect.neutral(kind.name, p).with_coordinates(moderate[:, (p or 1) - 1]) for p in places]
    kept = [e for e in chosen if e.key not in {t.key for t in tried}]
    return data.slope(here, data.realised([*kept, *tried]), 1.0) / data.noise


def _rests(parameters: Sequence[Parameter]) -> tuple[list[float], list[float]]:
    """Resting and typical coordinates."""
    return [p.resting for p in parameters], [p.coordinate(p.typical) for p in parameters]


def places_of(kind: Effect, data: Plays) -> list[int | None]:
    """Every joint that is read, or none."""
    return [None] if kind.place is None else [int(j) + 1 for j in np.flatnonzero(data.read.any(axis=0))]


def _scored(
    data: Plays, left: Floats, own: Sequence[Floats], everywhere: Sequence[Floats], at_joint: Sequence[Floats]
) -> Scored:
    """Sums joint by joint: columns of the chosen, then one of each effect everywhere, then of each at each joint."""
    labels = np.array(held_out_labels(data.recordings))[data.trials]
    shared, joints = len(own) + len(everywhere), left.shape[1]
    size, gaits = shared + len(at_joint) * joints, len(np.unique(labels))
    matrix, vector = np.zeros((gaits, size, size)), np.zeros((gaits, size))
    constant, count = np.zeros(gaits), np.array([float(data.read[labels == k].sum()) for k in np.unique(labels)])
    for j in range(joints):
        columns = np.stack([c[:, j] for c in (*own, *everywhere, *at_joint)], axis=1)
        e = Evidence.of(left[:, j], columns, labels)
        index = [*range(shared), *(shared + i * joints + j for i in range(len(at_joint)))]
        matrix[np.ix_(range(gaits), index, index)] += e.matrix
        vector[np.ix_(range(gaits), index)] += e.vector
        constant = constant + e.constant
    return Scored(Evidence(matrix, vector, constant, count), len(own), tuple((i,) for i in range(len(own), size)))


def slopes_of(data: Plays, chosen: Sequence[ActiveEffect], effect: ActiveEffect, here: Floats) -> tuple[Floats, Floats]:
    """Of what is played where it is read, and of what is left at the best shifts in time, by one chosen effect's
    coordinates, in units of noise (P, R, m); here: what all of them play."""
    others = [e for e in chosen if e.key != effect.key]
    late = data.met(chosen)[1] if isinstance(effect.effect, ActuationEffect) and effect.effect.dead_time else None
    played, missed = [], []
    for k, (p, x) in enumerate(zip(effect.effect.parameters, effect.coordinates, strict=False)):
        little = 1e-4 * max(abs(x), 1e-3 * abs(p.coordinate(p.typical)))
        step = (p.across if data.held else 0.0) or little
        effects = [*others, effect.moved(k, step)]
        moved = data.realised(effects)
        bare = moved if late is None else data.begun_at(effects, late)  # a start that is open would follow it
        played.append(np.where(data.read, bare - here, 0.0) / step / data.noise)
        missed.append(data.slope(here, moved, step) / data.noise)
    return np.stack(played), np.stack(missed)
