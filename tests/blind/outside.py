"""Hidden causes outside the catalogue: a diagnosis may describe their traces, and must never call them explained."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from blind.catalogue import Effect, World
from blind.ground import ExternalForce, Ground, PhaseSlip
from blind.schedule import Servos
from blind.snake import SNAKE10, Floats, Robot


def _magnet(rng: np.random.Generator, robot: Robot) -> tuple[Effect, World]:
    """One vertex is drawn to a point on the floor, the more the nearer."""
    size = robot.size
    vertex, pull = int(rng.choice([0, robot.vertices - 1])), size * float(rng.uniform(0.01, 0.03))
    centre, reach = size * rng.uniform(-0.3, 0.3, 2), size * float(rng.uniform(0.15, 0.3))

    def force(p: Floats, time: Floats) -> Floats:
        f = np.zeros_like(p)
        away = centre - p[:, vertex]
        near = (away**2).sum(axis=1, keepdims=True)
        f[:, vertex] = pull * away / reach * np.exp(-near / (2 * reach**2))
        return f

    return Effect("magnet", vertex, {"pull": pull}), World(Ground(0.2, robot, external=(force,)))


def _tether(rng: np.random.Generator, robot: Robot) -> tuple[Effect, World]:
    """A vertex tied by an elastic string to a point; slack while near it."""
    vertex = int(rng.integers(robot.vertices // 4, robot.vertices - robot.vertices // 4))
    length, stiffness = robot.size * float(rng.uniform(0.08, 0.2)), float(rng.uniform(0.1, 0.4))
    anchor = robot.size * rng.uniform(-0.1, 0.1, 2)

    def force(p: Floats, time: Floats) -> Floats:
        f = np.zeros_like(p)
        away = anchor - p[:, vertex]
        far = np.linalg.norm(away, axis=1, keepdims=True)
        f[:, vertex] = stiffness * np.maximum(far - length, 0) * away / np.maximum(far, 1e-9)
        return f

    parameters = {"length": length, "stiffness": stiffness}
    return Effect("tether", vertex, parameters), World(Ground(0.2, robot, external=(force,)))


def gust(seed: int, pull: float, weights: Floats) -> Callable[[int], ExternalForce]:
    """A push on the whole body at a moment and in a direction of its own in every trial."""

    def of_trial(trial: int) -> ExternalForce:
        rng = np.random.default_rng([seed, trial])
        when, lasts, angle = rng.uniform(0.5, 6.0), rng.uniform(0.3, 1.0), rng.uniform(0, 2 * np.pi)
        direction = pull * np.array([np.cos(angle), np.sin(angle)])

        def force(p: Floats, time: Floats) -> Floats:
            blowing = np.exp(-(((time - when) / lasts) ** 4))
            return blowing[:, None, None] * weights[:, None] * direction + np.zeros_like(p)

        return force

    return of_trial


def _gust(rng: np.random.Generator, robot: Robot) -> tuple[Effect, World]:
    pull = robot.size * float(rng.uniform(0.01, 0.04))
    blowing = gust(int(rng.integers(2**32)), pull, robot.weights)
    return Effect("gust", None, {"pull": pull}), World(Ground(0.2, robot), gust=blowing)


def _phase_slip(rng: np.random.Generator, robot: Robot) -> tuple[Effect, World]:
    slip = PhaseSlip(
        vertex=int(rng.integers(robot.vertices)),
        centre=float(rng.uniform()),
        width=float(rng.uniform(0.2, 0.45)),
        left_over=float(rng.uniform(0.0, 0.2)),
    )
    return Effect("phase_slip", slip.vertex, {"width": slip.width}), World(Ground(0.2, robot, phase_slips=(slip,)))


def _varying_lag(rng: np.random.Generator, robot: Robot) -> tuple[Effect, World]:
    lag, period, phase = float(rng.uniform(0.03, 0.12)), float(rng.uniform(3, 9)), float(rng.uniform(0, 6))
    world = World(Ground(0.2, robot), servos=Servos(varying_lag=(lag, period, phase)))
    return Effect("varying_lag", None, {"lag": lag, "period": period}), world


def _bump(rng: np.random.Generator, robot: Robot) -> tuple[Effect, World]:
    """Every vertex on the bump is pushed off it."""
    size, weights = robot.size, robot.weights
    pull, centre = size * float(rng.uniform(0.01, 0.04)), size * rng.uniform(-0.3, 0.3, 2)
    reach = size * float(rng.uniform(0.08, 0.2))

    def force(p: Floats, time: Floats) -> Floats:
        away = p - centre
        height = np.exp(-(away**2).sum(axis=-1, keepdims=True) / (2 * reach**2))
        return weights[:, None] * pull * away / reach * height

    return Effect("bump", None, {"pull": pull}), World(Ground(0.2, robot, external=(force,)))


OUTSIDE: dict[str, Callable[[np.random.Generator, Robot], tuple[Effect, World]]] = {
    "magnet": _magnet,
    "tether": _tether,
    "gust": _gust,
    "phase_slip": _phase_slip,
    "varying_lag": _varying_lag,
    "bump": _bump,
}


def draw_outside(
    rng: np.random.Generator, eps: float, name: str | None = None, robot: Robot = SNAKE10
) -> tuple[Effect, World]:
    """One of them, uniformly."""
    effect, world = OUTSIDE[name or str(rng.choice(sorted(OUTSIDE)))](rng, robot)
    return effect, replace(world, ground=replace(world.ground, eps=eps))
