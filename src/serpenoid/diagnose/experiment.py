"""The next experiment: the gait and cycle duration for which rival explanations predict most differently.

Among random ellipses within the robot's limits, at three durations, then a local improvement: the largest of the
least squared difference of the rivals' window displacements, in units of window noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.geometry import relative, shapes
from serpenoid.diagnose.medium import Noise
from serpenoid.diagnose.windows import STEPS_PER_WINDOW, WINDOWS_PER_CYCLE, predicted_path
from serpenoid.errors import InputError
from serpenoid.gaits import EllipseGait
from serpenoid.mechanics.tables import joint_table
from serpenoid.model import Model

ROWS = 50
GAITS, IMPROVEMENTS = 24, 12
LIMIT_DEG, SPEED_LIMIT_RPM, SHARE = 60.0, 57.0, 0.8  # where the body does not say; share of the speed used


@dataclass(frozen=True)
class Experiment:
    """Joint table (T, m) [rad], cycle duration [s], and how far apart the rivals' predictions are [SD]."""

    table: Floats
    cycle_duration_s: float
    separation: float


def next_experiment(
    models: Sequence[Model], noise: Noise, durations: Sequence[float], heading: float
) -> Experiment | None:
    """The best of the tried experiments to tell the first model from each of the others."""
    rng = np.random.default_rng(0)
    tried: list[tuple[float, Floats, float]] = []
    for _ in range(GAITS):
        tried += _scored(models, noise, _random(rng), durations, heading)
    if not tried:
        return None
    tried.sort(key=lambda t: -t[0])
    best = tried[0]
    for _ in range(IMPROVEMENTS):
        near = best[1] * np.exp(rng.normal(0, 0.08, 6)) + rng.normal(0, 0.05, 6)
        best = max([best, *_scored(models, noise, near, [best[2]], heading)], key=lambda t: t[0])
    return Experiment(table_of(models[0], best[1]), best[2], float(np.sqrt(best[0])))


def _random(rng: np.random.Generator) -> Floats:
    sigma = rng.choice([-1, 1]) * rng.uniform(0.35, 1.0)
    centre, angle = rng.uniform(-2.5, 2.5, 2), rng.uniform(-np.pi, np.pi)
    return np.array([sigma, *centre, angle, rng.uniform(3.5, 8), rng.uniform(0.75, 1.5)])


def table_of(model: Model, gait: Floats) -> Floats:
    """Joint table (T, m) of ellipse parameters (6,)."""
    return np.round(joint_table(model, EllipseGait.from_parameters(gait).parameters, ROWS), 6)


def _scored(
    models: Sequence[Model], noise: Noise, gait: Floats, durations: Sequence[float], heading: float
) -> list[tuple[float, Floats, float]]:
    table = table_of(models[0], gait)
    body = models[0].body
    limit = np.deg2rad(body.joint_limit_deg or LIMIT_DEG)
    speed_limit = SHARE * (body.joint_speed_limit_rpm or SPEED_LIMIT_RPM) * 2 * np.pi / 60
    fastest = np.abs(np.diff(table, axis=0, append=table[:1])).max() * ROWS
    result = []
    for duration in durations:
        if np.abs(table).max() > limit or fastest / duration > speed_limit:
            continue
        apart = [_apart(models[0], m, table, duration, noise, heading) for m in models[1:]]
        if apart and np.isfinite(apart).all():
            result.append((min(apart), gait, duration))
    return result


def _apart(one: Model, other: Model, table: Floats, duration: float, noise: Noise, heading: float) -> float:
    n = WINDOWS_PER_CYCLE * STEPS_PER_WINDOW // 2
    time = np.linspace(0, duration, n + 1)
    closed = np.concatenate([table, table[:1]])
    angles = np.stack([np.interp(time / duration * ROWS, np.arange(ROWS + 1), c) for c in closed.T], axis=1)
    vertices = shapes(one.body, angles)
    start = np.array([0.0, 0.0, heading])
    try:
        a, b = (predicted_path(m, vertices, time, start)[:: STEPS_PER_WINDOW // 2] for m in (one, other))
    except (InputError, ArithmeticError):
        return float("nan")
    d = (relative(a[:-1], a[1:]) - relative(b[:-1], b[1:])) / noise.playing
    return float((d**2).sum())
