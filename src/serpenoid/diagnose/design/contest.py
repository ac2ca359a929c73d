"""How surely a planned trial would tell two explanations apart: expected chi squared, parameters fitted again.

    d^T (I / K + Q_a Q_a^T + Q_b Q_b^T)^{-1} d

d: difference of the predicted window displacements in their noise, K: independent repeats, Q: what each explanation's
predictions move by when its eps and parameters move by one standard deviation of their fit, axis by axis. So a
difference that eps or a rival's own parameters could take up, within what the campaign leaves open, does not count.

Legend: W windows, P parameters.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.cameras.frame import added, of_frame
from serpenoid.diagnose.data.noise.motion import Noise
from serpenoid.diagnose.data.shapes.geometry import shapes
from serpenoid.diagnose.data.windows.windows import predicted_path
from serpenoid.diagnose.inference.fits.medium import Fit, with_values
from serpenoid.errors import InputError
from serpenoid.group import relative
from serpenoid.measure.schedule import Schedule
from serpenoid.model import Model

WINDOWS, STEPS, PAUSE_STEPS = 8, 7, 4  # a cycle's windows, steps in each, steps in each half of a pause
PART = 0.1  # of a standard deviation: steps of the derivatives


@dataclass(frozen=True)
class Plan:
    """A trial that could be played: schedule, start pose (3,) [m, rad] on the floor, how often it would be repeated."""

    schedule: Schedule
    start: Floats
    repeats: int = 2

    @property
    def mesh(self) -> tuple[Floats, np.ndarray, np.ndarray]:
        """Times of the rows of one period, rows where windows end (W + 1,), and which windows (W,) are played."""
        s = self.schedule
        time = np.linspace(0, s.cycle_duration_s, WINDOWS * STEPS + 1)
        bounds, playing = STEPS * np.arange(WINDOWS + 1), np.ones(WINDOWS, bool)
        if s.pause_s > 0:
            rest = np.linspace(0, s.pause_s, 2 * PAUSE_STEPS + 1)[1:]
            time = np.concatenate([time, s.cycle_duration_s + rest])
            bounds = np.concatenate([bounds, bounds[-1] + PAUSE_STEPS * np.arange(1, 3)])
            playing = np.concatenate([playing, np.zeros(2, bool)])
        return time, bounds, playing


class Unplayable(ArithmeticError):
    """A model has no motion for a plan."""


@dataclass(frozen=True)
class Explanation:
    """A fit with the principal axes (P, P) of its parameters' covariance, one standard deviation long."""

    fit: Fit
    axes: Floats

    @classmethod
    def of(cls, fit: Fit) -> Explanation:
        _, covariance = fit.evidence.solve(range(len(fit.coordinates)))
        size, axis = np.linalg.eigh(covariance)
        return cls(fit, (axis * np.sqrt(np.maximum(size, 0.0))).T)

    def predicted(self, plan: Plan) -> Floats:
        """Window displacements (W, 3) [m, m, rad] of one period."""
        return _displacements(self.fit.model, plan)

    def spread(self, plan: Plan, middle: Floats) -> Floats:
        """What they move by along each axis (P, W, 3)."""
        x, effects = self.fit.coordinates, self.fit.effects
        moved = [_displacements(with_values(self.fit.model, effects, x + PART * a), plan) for a in self.axes]
        return (np.array(moved) - middle) / PART


def expected_chi2(one: Explanation, others: list[Explanation], noise: Noise, plan: Plan) -> Floats:
    """By how much each of the others (n,) would lose, or win, against the first; Unplayable where a model fails."""
    middle = one.predicted(plan)
    white = np.where(plan.mesh[2][:, None], noise.playing, noise.pause)
    repeats = plan.repeats * plan.schedule.cycles
    common = np.eye(white.size) / repeats + _outer(one.spread(plan, middle) / white)
    found = []
    for other in others:
        there = other.predicted(plan)
        d = ((middle - there) / white).ravel()
        found.append(d @ np.linalg.solve(common + _outer(other.spread(plan, there) / white), d))
    return np.array(found)


def _outer(columns: Floats) -> Floats:
    flat = columns.reshape(len(columns), -1)
    return np.asarray(flat.T @ flat)


def _displacements(model: Model, plan: Plan) -> Floats:
    time, bounds, _ = plan.mesh
    vertices = shapes(model.body, plan.schedule.commanded(time))
    try:
        path = predicted_path(model, vertices, time, plan.start)[bounds]
    except (InputError, np.linalg.LinAlgError) as error:
        raise Unplayable(str(error)) from error
    moved = relative(path[:-1], path[1:]) + added(of_frame(model.effects), path, time[bounds])
    if not np.isfinite(moved).all():
        raise Unplayable("no root")
    return moved
