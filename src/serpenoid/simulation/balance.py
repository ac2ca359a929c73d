"""Steps with effects that do not depend on each other: Newton's method for all of them at once.

Each step starts from the baseline's root and has a damping of its own. Where that fails, the effects are switched on
little by little. A root is sound if the residual vanishes and its derivative has the sign of a resisting medium.

Legend: S steps, M elements.
"""

from __future__ import annotations

from dataclasses import dataclass

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


def solve_balance(
    model: Model,
    before: Floats,
    after: Floats,
    times: Floats,
    starts: Floats,
    guess: Floats,
    coast: Coast | None = None,
) -> Steps:
    """Relative poses of S steps between `times` (S, 2) [s], from poses `starts` (S, 3) on the floor.

    before, after: elements (4, M S). guess (S, 3): relative poses, usually the baseline's. Without `coast` effects
    that know history are left out.
    """
    coast = coast or Coast(np.zeros(len(guess)), np.zeros((len(guess), 3)))
    root = _newton(model, before, after, times, starts, compose(starts, guess), coast, 1.0)
    for strength in STRENGTHS:
        bad = ~root.sound
        if not bad.any():
            break
        if strength == STRENGTHS[0]:
            root.relative[bad] = compose(starts, guess)[bad]
        again = _subset(model, before, after, bad)
        part = _newton(model, *again, times[bad], starts[bad], root.relative[bad], coast.part(bad), strength)
        root.relative[bad] = part.relative
        if strength == STRENGTHS[-1]:
            root.sound[bad], root.residual[bad], root.energy[bad] = part.sound, part.residual, part.energy
    return Steps(relative(starts, root.relative), root.energy, root.residual, root.sound)


def _newton(
    model: Model,
    before: Floats,
    after: Floats,
    times: Floats,
    starts: Floats,
    ends: Floats,
    coast: Coast,
    strength: float,
) -> Steps:
    """Damped Newton for the second poses; `relative` of the answer holds poses on the floor."""
    law, m = MediumNumbers.of(model, strength), model.structure.elements
    home, count = starts * [1, 1, 0], len(ends)
    settings, carried = law.settings(times), about(coast.carried, home)
    settings[3:5] = home[:, :2].T
    residual, energy = np.full(count, np.inf), np.full(count, np.nan)
    slopes = np.zeros((count, 3, 3))
    damping, step = np.ones(count), np.zeros((count, 3))
    base, turned = ends - home, starts - home
    todo = np.arange(count)
    for _ in range(ITERATIONS):
        trial = base[todo] + damping[todo, None] * step[todo]
        part = _columns(before, todo, m), _columns(after, todo, m)
        poses = np.hstack([turned[todo], trial]).T
        value, work, slope = evaluate("balance", law, *part, poses, settings[:, todo])
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
    return Steps(base + home, energy, residual, sound)


def _solve(matrix: Floats, right: Floats) -> Floats:
    """Solutions of 3 x 3 systems; a singular one is met by a short step downhill."""
    singular = ~(np.abs(np.linalg.det(matrix)) > 1e-300)
    regular = np.where(singular[:, None, None], np.eye(3), matrix)
    return np.asarray(np.linalg.solve(regular, right[..., None])[..., 0], np.float64)


def _columns(elements: Floats, steps: np.ndarray, m: int) -> Floats:
    return elements.reshape(4, -1, m)[:, steps].reshape(4, -1)


def _subset(model: Model, before: Floats, after: Floats, keep: np.ndarray) -> tuple[Floats, Floats]:
    m, steps = model.structure.elements, np.flatnonzero(keep)
    return _columns(before, steps, m), _columns(after, steps, m)


def about(momenta: Floats, point: Floats) -> Floats:
    """Momenta (S, 3) whose angular part is about `point` (3,) or (S, 3) instead of the origin."""
    angular = momenta[:, 2] - (point[..., 0] * momenta[:, 1] - point[..., 1] * momenta[:, 0])
    return np.column_stack([momenta[:, :2], angular])


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
