"""Steps with effects that do not depend on each other: Newton's method for all of them at once.

Each step starts from the baseline's root and has a damping of its own. Where that fails, the effects are switched on
little by little. A root is sound if the residual vanishes and its derivative has the sign of a resisting medium.

Legend: S steps, M elements.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.model import Model
from serpenoid.simulation.law import MediumNumbers, evaluate
from serpenoid.simulation.steps import TOLERANCE, Steps

ITERATIONS = 60
STRENGTHS = (0.1, 0.25, 0.5, 0.75, 1.0)


@dataclass(frozen=True)
class Coast:
    """What earlier momenta add to the residual: `rate` (S,) times this step's momentum, and `carried` (S, 3)."""

    rate: Floats
    carried: Floats

    def part(self, keep: np.ndarray) -> Coast:
        """Some of the steps."""
        return Coast(self.rate[keep], self.carried[keep])


@dataclass(frozen=True)
class Balance(Steps):
    """Steps, and the derivatives (S, 3, 3) of their residuals about the floor's origin by the second poses."""

    slopes: Floats


def solve_balance(
    model: Model,
    before: Floats,
    after: Floats,
    times: Floats,
    starts: Floats,
    guess: Floats,
    coast: Coast | None = None,
) -> Balance:
    """Relative poses of S steps between `times` (S, 2) [s], from poses `starts` (S, 3) on the floor.

    before, after: elements (4, M S). guess (S, 3): relative poses, usually the baseline's. Without `coast` effects
    that know history are left out.
    """
    coast = coast or at_rest(len(guess))
    root = _newton(model, before, after, times, starts, compose(starts, guess), coast, 1.0)
    for strength in STRENGTHS:
        bad = ~root.sound
        if not bad.any():
            break
        if strength == STRENGTHS[0]:
            root.relative[bad] = compose(starts, guess)[bad]
        again = _subset(before, after, bad)
        part = _newton(model, *again, times[bad], starts[bad], root.relative[bad], coast.part(bad), strength)
        root.relative[bad] = part.relative
        if strength == STRENGTHS[-1]:
            root.sound[bad], root.residual[bad], root.energy[bad] = part.sound, part.residual, part.energy
            root.slopes[bad] = part.slopes
    return replace(root, relative=relative(starts, root.relative))


def solve_near(
    model: Model,
    before: Floats,
    after: Floats,
    times: Floats,
    starts: Floats,
    near: Floats,
    coast: Coast | None = None,
) -> Balance:
    """The same from relative poses `near` (S, 3) of a model much like this one; those that lead nowhere not sound."""
    found = _newton(model, before, after, times, starts, compose(starts, near), coast or at_rest(len(near)), 1.0)
    return replace(found, relative=relative(starts, found.relative))


def at_rest(count: int) -> Coast:
    """No earlier momenta."""
    return Coast(np.zeros(count), np.zeros((count, 3)))


def _newton(
    model: Model,
    before: Floats,
    after: Floats,
    times: Floats,
    starts: Floats,
    ends: Floats,
    coast: Coast,
    strength: float,
) -> Balance:
    """Damped Newton for the second poses; `relative` of the answer holds poses on the floor."""
    law = MediumNumbers.of(model, strength)
    home, count = starts * [1, 1, 0], len(ends)
    settings, carried = law.settings(times), about(coast.carried, home)
    settings[3:5] = home[:, :2].T
    residual, energy = np.full(count, np.inf), np.full(count, np.nan)
    slopes = np.zeros((count, 3, 3))
    damping, step = np.ones(count), np.zeros((count, 3))
    base, turned = ends - home, starts - home
    elements = by_step(before, count), by_step(after, count)
    todo = np.arange(count)
    for _ in range(ITERATIONS):
        trial = base[todo] + damping[todo, None] * step[todo]
        first, last = (x[todo].reshape(-1, 4).T for x in elements)
        poses = np.hstack([turned[todo], trial]).T
        value, work, slope = evaluate("balance", law, first, last, poses, settings[:, todo])
        rate = coast.rate[todo, None]
        excess = value[:, :3] + rate * value[:, 3:] + carried[todo]
        size = np.abs(excess).max(1)
        size = np.where(np.isfinite(size), size, np.inf)
        better = size < residual[todo]
        won, lost = todo[better], todo[~better]
        base[won], residual[won], energy[won] = trial[better], size[better], work[better]
        slopes[won] = (slope[:, :3] + rate[..., None] * slope[:, 3:])[better]
        step[won] = -_solve(slopes[won], excess[better])
        damping[won], damping[lost] = np.minimum(1.0, 2 * damping[won]), damping[lost] / 3
        todo = todo[(residual[todo] > TOLERANCE / 10) & (damping[todo] > 1e-8)]
        if todo.size == 0:
            break
    sound = (residual <= TOLERANCE) & (np.linalg.det(slopes) > 0)
    return Balance(base + home, energy, residual, sound, about(slopes, -home))


def _solve(matrix: Floats, right: Floats) -> Floats:
    """Solutions of 3 x 3 systems; a singular one is met by a short step downhill."""
    singular = ~(np.abs(np.linalg.det(matrix)) > 1e-300)
    regular = np.where(singular[:, None, None], np.eye(3), matrix)
    return np.asarray(np.linalg.solve(regular, right[..., None])[..., 0], np.float64)


def by_step(elements: Floats, count: int) -> Floats:
    """Elements (4, M S) step by step in memory (S, 4 M)."""
    return np.ascontiguousarray(elements.T).reshape(count, -1)


def _subset(before: Floats, after: Floats, keep: np.ndarray) -> tuple[Floats, Floats]:
    first, second = (by_step(x, len(keep))[keep].reshape(-1, 4).T for x in (before, after))
    return first, second


def about(momenta: Floats, point: Floats) -> Floats:
    """Momenta (S, 3) whose angular part is about `point` (3,) or (S, 3) instead of the origin; or derivatives of them
    (S, 3, P)."""
    moved = momenta.copy()
    x, y = (point[..., i].reshape(-1, *[1] * (momenta.ndim - 2)) for i in range(2))
    moved[:, 2] -= x * momenta[:, 1] - y * momenta[:, 0]
    return moved


def compose(starts: Floats, relative: Floats) -> Floats:
    """Poses reached from `starts` (S, 3) by relative motions (S, 3)."""
    c, s = np.cos(starts[:, 2]), np.sin(starts[:, 2])
    x = starts[:, 0] + c * relative[:, 0] - s * relative[:, 1]
    y = starts[:, 1] + s * relative[:, 0] + c * relative[:, 1]
    return np.column_stack([x, y, starts[:, 2] + relative[:, 2]])


def relative(starts: Floats, ends: Floats) -> Floats:
    """Poses `ends` (S, 3) in the frames of `starts` (S, 3)."""
    d = ends - starts
    c, s = np.cos(starts[:, 2]), np.sin(starts[:, 2])
    return np.column_stack([c * d[:, 0] + s * d[:, 1], c * d[:, 1] - s * d[:, 0], d[:, 2]])
