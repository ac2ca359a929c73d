"""One actuation effect fitted at every joint, all side by side: joints do not touch each other, so that one evaluation
of what servos play moves it at each of them.

Gauss-Newton with a damping for each joint; of every candidate, for the search.

Legend: R log rows of all trials, m joints, P parameters of an effect, K places.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.stages.actuation.actuation_candidates import places_of, shown
from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import ActuationEffect, Parameter
from serpenoid.effects.catalogue import find
from serpenoid.files.store import remembered
from serpenoid.parallel import in_processes

STEPS = 7
HALVINGS = 6  # of an octave: about a hundredth, of a tenth of a second as little as logs leave open
REACH, SHRUNK = 3.0, 0.7  # of a positive scale: by how much more, and less, it is at most after one step
RIDGE = 1e-9  # of a parameter's own slope, where two may do the same


@dataclass(frozen=True)
class Attempt:
    """An effect fitted at one joint or at all: the effect, chi squared per joint (m,) with it."""

    effect: ActiveEffect
    chi2: Floats


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

    without, each = (data.realised(base), data.realised_each) if only is None else data.at_joint(only, base)

    def with_these(x: Floats) -> list[ActiveEffect]:
        effects = [ActiveEffect.neutral(name, place).with_coordinates(v) for place, v in zip(places, x.T, strict=True)]
        return [*base, *effects]

    def play_each(several: Sequence[Floats]) -> list[Floats]:
        return each([with_these(x) for x in several])

    def play(x: Floats) -> Floats:
        return play_each([x])[0]

    def own(by_joint: Floats) -> Floats:
        return by_joint.sum(keepdims=True) if kind.place is None else by_joint[columns]

    begun = [np.atleast_2d(start)[:, columns] for start in starts]
    tried = [own(data.chi2(x)) for x in play_each(begun)] if len(begun) > 1 else [np.zeros(len(places))]
    values = np.choose(np.argmin(tried, axis=0), begun)
    if data.held and any(p.across for p in parameters):
        values = _narrowed(values, lambda x: own(data.chi2(play(x))))
    positive = np.array([p.lower >= 0 for p in parameters]) & (values > 0).all(axis=1)
    small = np.diag([p.small(data.held) for p in parameters])[..., None]
    sizes, near = small.sum(axis=0), 1e-4 * np.array([[abs(p.typical)] for p in parameters])
    best = play(values)
    left, damping = data.left(best), np.ones(len(places))
    for _ in range(STEPS):
        moved = play_each([values + step for step in small])
        slopes = [(left - data.left(x)) / size for x, size in zip(moved, sizes, strict=True)]
        # what is left is at the best moves of clocks, so that only the bare slope turns it into the gradient
        bare = [(x - best) / size for x, size in zip(moved, sizes, strict=True)]
        pull = np.stack([own((left * b).sum(axis=0) / data.noise**2) for b in bare])
        matrix = np.array([[own((s * b).sum(axis=0) / data.noise**2) for s in slopes] for b in bare])
        change = damping * _newton(matrix, pull)
        change = np.where(positive[:, None], in_reach(change, values), change)
        trial = np.array([[inside(p, v) for v in row] for p, row in zip(parameters, values + change, strict=True)])
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
        idle = np.all([x == best for x in play_each([values + step for step in small])], axis=(0, 1))
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


def in_reach(change: Floats, values: Floats) -> Floats:
    """Changes of positive scales, no larger than one step may make them."""
    return np.clip(change, -SHRUNK * np.abs(values), REACH * np.abs(values))


def inside(p: Parameter, coordinate: float) -> float:
    value = min(max(p.value(coordinate), p.lower), p.upper)
    return float(p.coordinate(value)) if np.isfinite(value) else float(coordinate)
