"""Separation S_ab: what the best-fitting rival b leaves of effect a, over the floor.

Rivals on the path stage are fitted together with eps to the clean paths, on the shape stage to the clean signature.
A rival on the other stage explains nothing of a: then S_ab = S_a.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import least_squares

from blind.campaign import Campaign
from blind.catalogue import CATALOGUE, Effect, world
from blind.motion import paths
from blind.snake import Floats, Robot
from blind.strength import (
    alone,
    clean_drives,
    clean_paths,
    null_fit,
    null_ground,
    on_path_rung,
    path_rms,
    registered,
    shape_signature,
    strength,
    worst_channel,
)

# Starting points in the fit's own coordinates, and the map to parameters. Positive scales are fitted as logarithms.
LOGARITHMIC = {
    "lag",
    "max_speed",
    "saturation_speed",
    "crossover_speed",
    "half_track",
    "relaxation_time",
    "radius",
    "width",
    "exponent",
    "damping",
}
STARTS: dict[str, list[dict[str, float]]] = {
    "servo_lag": [{"lag": 0.03}],
    "servo_delay": [{"delay": 0.03}],
    "servo_inertia": [{"lag": 0.03, "damping": 0.7}],
    "gain_loss": [{"loss": 0.1}],
    "zero_offset": [{"offset": 0.0}],
    "stuck_joint": [{"angle": 0.0}],
    "backlash": [{"width": 0.02}, {"width": 0.1}],
    "servo_play": [{"width": 0.02}, {"width": 0.1}],
    "loose_joint": [{"width": 0.02}, {"width": 0.1}],
    "speed_saturation": [{"max_speed": 0.6}, {"max_speed": 1.0}],
    "lagging_joint": [{"lag": 0.03}],
    "slow_joint": [{"max_speed": 0.6}, {"max_speed": 1.0}],
    "worn_wheel": [{"seizure": 0.3}],
    "rough_skin": [{"roughness": 0.0}],
    "load": [{"share": 0.0}],
    "tyre_grip": [{"change": 0.0}],
    "dry_friction": [{"crossover_speed": 0.02}, {"crossover_speed": 0.2}],
    "rolling_resistance": [{"crossover_speed": 0.02}, {"crossover_speed": 0.2}],
    "grip_saturation": [{"saturation_speed": 0.2}, {"saturation_speed": 0.05}],
    "forward_backward_asymmetry": [{"asymmetry": 0.0}],
    "left_right_asymmetry": [{"asymmetry": 0.0}],
    "track_width": [{"half_track": 0.05}],
    "wheel_mount": [{"share": 0.0}],
    "toe": [{"angle": 0.0}],
    "slope": [{"pull_x": 0.0, "pull_y": 0.0}],
    "friction_patch": [{"strength": s, "x": s / 4, "y": s / 4, "radius": 0.2} for s in (0.8, -0.5)],
    "grip_patch": [{"change": s, "x": s / 4, "y": s / 4, "radius": 0.2} for s in (0.8, -0.5)],
    "friction_gradient": [{"gradient_x": 0.0, "gradient_y": 0.0}],
    "anisotropy_drift": [{"rate": 0.0}],
    "power_law_drag": [{"exponent": 0.8}],
    "inertia": [{"relaxation_time": 0.03}, {"relaxation_time": 0.2}],
    "added_mass": [{"relaxation_time": 0.05}, {"relaxation_time": 0.5}],
    "contact_offset": [{"offset": 0.0}],
    "marker_offset": [{"along": 0.0, "left": 0.0}],
    "marker_offset_ahead": [{"along": 0.0, "left": 0.0}],
    "marker_sway": [{"sway": 0.0}],
    "length_scale": [{"error": 0.0}],
    "camera_stretch": [{"longer": 0.0, "shear": 0.0}],
    "clock_offset": [{"rate": 0.0}],
    "frame_drift": [{"velocity_x": 0.0, "velocity_y": 0.0}],
}
SCALE = {"pull_x": 1e-3, "pull_y": 1e-3, "velocity_x": 1e-3, "velocity_y": 1e-3, "along": 1e-3, "left": 1e-3}
SCALE |= {
    "offset": 0.01,
    "angle": 0.05,
    "rate": 0.01,
    "error": 0.01,
    "loss": 0.2,
    "width": 1.0,
    "sway": 1e-3,
    "longer": 0.01,
    "shear": 0.01,
}


def _bounds(name: str, parameter: str, place: int | None, robot: Robot) -> tuple[float, float]:
    if parameter in ("seizure", "loss"):
        return 0.0, 1.0
    if name == "wheel_mount":
        return -1.0, 1.0
    if parameter == "share":
        return -float(robot.weights[place or 0]), 1.0
    if parameter in ("strength", "roughness"):
        return -0.95, 20.0
    if name.endswith("asymmetry"):
        return -0.99, 0.99
    return -np.inf, np.inf


class _Coordinates:
    """Between parameters and the fit's vector."""

    def __init__(self, name: str, place: int | None, start: dict[str, float], robot: Robot):
        self.name, self.place, self.names = name, place, list(start)
        self.start = np.array([self._in(n, v) for n, v in start.items()])
        box = [_bounds(name, n, place, robot) for n in self.names]
        inside = [
            b if n in LOGARITHMIC else (b[0] / SCALE.get(n, 1), b[1] / SCALE.get(n, 1))
            for n, b in zip(self.names, box, strict=True)
        ]
        self.low, self.high = np.array([b[0] for b in inside]), np.array([b[1] for b in inside])
        wide = np.array([n in LOGARITHMIC for n in self.names])
        self.low, self.high = np.where(wide, self.start - 6, self.low), np.where(wide, self.start + 6, self.high)

    def _in(self, name: str, value: float) -> float:
        return float(np.log(value)) if name in LOGARITHMIC else value / SCALE.get(name, 1.0)

    def effect(self, x: Floats) -> Effect:
        values = [np.exp(v) if n in LOGARITHMIC else v * SCALE.get(n, 1.0) for n, v in zip(self.names, x, strict=True)]
        return Effect(self.name, self.place, dict(zip(self.names, map(float, values), strict=True)))


def _fit(residual: Callable[[Floats], Floats], x: Floats, low: Floats, high: Floats) -> Floats:
    return least_squares(residual, x, bounds=(low, high), diff_step=1e-3, max_nfev=25, x_scale=1.0).x


def _path_left(c: Campaign, name: str, place: int | None, start: dict[str, float]) -> float:
    numbers = [i for i, t in enumerate(c.trials) if t.name.endswith("-1")]
    drives = clean_drives(c, one_per_setting=True)
    targets = clean_paths(c, drives, numbers)
    robot = c.world.ground.robot
    k = _Coordinates(name, place, start, robot)
    eps = null_fit(drives, targets, null_ground(c)).eps

    def difference(x: Floats) -> list[Floats]:
        w = world(float(np.exp(x[0])), [*c.base, k.effect(x[1:])], robot)
        drift = np.array([*w.cameras.drift, 0.0])
        moved = [p + d.time[:, None] * drift for p, d in zip(paths(w.ground, drives), drives, strict=True)]
        return [registered(p, t, robot.length) - t[:, :2] for p, t in zip(moved, targets, strict=True)]

    def residual(x: Floats) -> Floats:
        try:
            return np.concatenate([(d[::4] / np.sqrt(len(d))).ravel() for d in difference(x)]) * 1e3
        except (ArithmeticError, np.linalg.LinAlgError):
            return np.full(sum(2 * len(t[::4]) for t in targets), 1e3)

    x0 = np.r_[np.log(eps), k.start]
    x = _fit(residual, x0, np.r_[np.log(5e-3), k.low], np.r_[np.log(1.0) + 1e-9, k.high])
    return path_rms(difference(x))


def _shape_left(c: Campaign, truth: Effect, name: str, place: int | None, start: dict[str, float]) -> float:
    robot = c.world.ground.robot
    target = shape_signature(c, world(c.eps, [truth], robot))
    k = _Coordinates(name, place, start, robot)

    def left(x: Floats) -> Floats:
        return shape_signature(c, world(c.eps, [k.effect(x)], robot)) - target

    return worst_channel(left(_fit(lambda x: left(x)[::5].ravel(), k.start, k.low, k.high)))


def separation(c: Campaign, truth: Effect, name: str, place: int | None, noise_floor: float) -> float:
    """S_ab of hidden effect `truth` from the rival (name, place); infinity for a name that cannot be fitted here."""
    if name not in CATALOGUE or place not in CATALOGUE[name].places(c.world.ground.robot):
        return float("inf")
    if name not in STARTS or on_path_rung(Effect(name, place)) != on_path_rung(truth):
        return strength(c, truth, noise_floor)
    if on_path_rung(truth):
        single = alone(c, truth)
        return min(_path_left(single, name, place, s) for s in STARTS[name]) / noise_floor
    return min(_shape_left(c, truth, name, place, s) for s in STARTS[name])
