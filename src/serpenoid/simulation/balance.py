"""Steps with effects that do not depend on each other: Newton's method for all of them, side by side.

Each step starts from the baseline's root. Where that fails, the effects are switched on little by little. A root is
sound if the residual vanishes, but for rounding, and its derivative has the sign of a resisting medium. Dry friction
has roots half a turn away; a root farther than a resolved step goes is taken only where nothing nearer leads on.

Legend: S steps, M elements.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from serpenoid import group
from serpenoid.body import Floats
from serpenoid.mechanics.extended import held_for
from serpenoid.mechanics.roots import roots
from serpenoid.model import Model
from serpenoid.simulation.law import MediumNumbers, evaluate
from serpenoid.simulation.newton import ENOUGH, ITERATIONS, LEAST_DAMPING, State, at_root, newton
from serpenoid.simulation.steps import SUSPICIOUS_TURN, Steps

FAR = SUSPICIOUS_TURN  # [body lengths, rad] a step of a resolved gait goes far less
STRENGTHS = (0.1, 0.25, 0.5, 0.75, 1.0)
LIMITS = np.array([ENOUGH, LEAST_DAMPING, ITERATIONS])


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


@dataclass(frozen=True)
class Placed:
    """S steps on the floor: elements (4, M S) before and after, between times (S, 2) [s], from poses (S, 3) on.

    Without `coast` effects that know history are left out.
    """

    before: Floats
    after: Floats
    times: Floats
    starts: Floats
    coast: Coast | None = None

    def part(self, keep: np.ndarray) -> Placed:
        """Some of the steps: their numbers, or which (S,)."""
        before, after = (some_steps(x, len(self.starts), keep) for x in (self.before, self.after))
        coast = None if self.coast is None else self.coast.part(keep)
        return Placed(before, after, self.times[keep], self.starts[keep], coast)


def solve_balance(model: Model, steps: Placed, guess: Floats) -> Balance:
    """Relative poses of steps; guess (S, 3): where the search begins, usually the baseline's."""
    begin = group.compose(steps.starts, guess)
    root = _newton(model, steps, begin, 1.0)
    for strength in STRENGTHS:
        bad = ~root.sound
        if not bad.any():
            break
        if strength == STRENGTHS[0]:
            root.relative[bad] = begin[bad]
        most = np.inf if strength == STRENGTHS[-1] else FAR
        part = _newton(model, steps.part(bad), root.relative[bad], strength, most)
        root.relative[bad] = part.relative
        if strength == STRENGTHS[-1]:
            root.sound[bad], root.residual[bad], root.energy[bad] = part.sound, part.residual, part.energy
            root.slopes[bad] = part.slopes
    return replace(root, relative=group.relative(steps.starts, root.relative))


def solve_near(model: Model, steps: Placed, near: Floats) -> Balance:
    """The same from relative poses `near` (S, 3) of a model much like this one; those that lead nowhere not sound."""
    found = _newton(model, steps, group.compose(steps.starts, near), 1.0)
    return replace(found, relative=group.relative(steps.starts, found.relative))


def at_rest(count: int) -> Coast:
    """No earlier momenta."""
    return Coast(np.zeros(count), np.zeros((count, 3)))


def _newton(model: Model, steps: Placed, ends: Floats, strength: float, most: float = FAR) -> Balance:
    """The second poses by Newton's method from `ends` (S, 3) on, sound where they are no farther than `most` [body
    lengths, rad]; `relative` of the answer holds poses on the floor."""
    starts, coast = steps.starts, steps.coast or at_rest(len(ends))
    law, home = MediumNumbers.of(model, strength), starts * [1, 1, 0]
    settings, carried = law.settings(steps.times).T, about(coast.carried, home)
    settings[:, 3:5] = home[:, :2]
    chains = [by_step(x, len(ends)).reshape(len(ends), -1, 4) for x in (steps.before, steps.after)]
    given = *chains, starts - home, settings, coast.rate, carried, ends - home
    run = roots(law.kind, held_for(law.acting))
    found = plain_roots(law, *given) if run is None else run(*given, law.medium.T, law.theta.T, LIMITS)
    moved, slopes, energy, size = found
    near = np.abs(moved - (starts - home)).max(1) <= most
    sound = at_root(size, slopes) & (np.linalg.det(slopes) > 0) & near
    return Balance(moved + home, energy, size, sound, about(slopes, -home))


def plain_roots(
    law: MediumNumbers,
    before: Floats,
    after: Floats,
    starts: Floats,
    settings: Floats,
    rate: Floats,
    carried: Floats,
    guess: Floats,
) -> tuple[Floats, Floats, Floats, Floats]:
    """What `mechanics.roots` gives, where nothing can be compiled."""

    def equations(trial: Floats, steps: np.ndarray) -> State:
        first, last = (x[steps].reshape(-1, 4).T for x in (before, after))
        poses = np.hstack([starts[steps], trial]).T
        value, energy, slope = evaluate("balance", law, first, last, poses, settings[steps].T)
        by = rate[steps, None]
        residual = value[:, :3] + by * value[:, 3:] + carried[steps]
        return State(residual, (slope[:, :3] + by[..., None] * slope[:, 3:])[None], (energy,))

    ends, state = newton(equations, guess)
    return ends, state.slopes[0], state.more[0], state.size


def by_step(elements: Floats, count: int) -> Floats:
    """Elements (4, M S) step by step in memory (S, 4 M)."""
    return np.ascontiguousarray(elements.T).reshape(count, -1)


def some_steps(elements: Floats, count: int, keep: np.ndarray) -> Floats:
    """Elements (4, M K) of K of `count` steps: their numbers, or which (S,)."""
    return np.asarray(by_step(elements, count)[keep].reshape(-1, 4).T)


def about(momenta: Floats, point: Floats) -> Floats:
    """Momenta (S, 3) whose angular part is about `point` (3,) or (S, 3) instead of the origin; or derivatives of them
    (S, 3, P)."""
    moved = momenta.copy()
    x, y = (point[..., i].reshape(-1, *[1] * (momenta.ndim - 2)) for i in range(2))
    moved[:, 2] -= x * momenta[:, 1] - y * momenta[:, 0]
    return moved
