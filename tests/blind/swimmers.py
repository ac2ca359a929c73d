"""Swimmers that were filmed and nothing else: no command, no servo, no schedule; points of a body already under way.

A wave of bending runs down the chain of `blind.snake`; its amplitude, frequency and turning wander slowly, as an
animal's do. What moves it is a `Ground` (water is one to those who resist linearly), from rest long before the film.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from blind.ground import ExternalForce, Ground
from blind.motion import Drive, paths
from blind.snake import EDGES, JOINTS, VERTICES, WEIGHTS, Floats, vertices

FRAMES_PER_SECOND = 60.0
NOISE = 5e-4  # m of a point
SPIN_UP_S = 6.0
STEPS_PER_SECOND = 600


@dataclass(frozen=True)
class Swimmer:
    """What it swims in, the seed of how it swims and of the film's noise, and how long it is filmed [s]."""

    ground: Ground
    seed: int
    film_s: float = 8.0

    def film(self) -> tuple[Floats, Floats]:
        """Times (F,) [s] and points (F, N, 2) [m], tail first."""
        rng = np.random.default_rng(self.seed)
        time = np.arange(int((SPIN_UP_S + self.film_s) * STEPS_PER_SECOND) + 1) / STEPS_PER_SECOND
        phi = bending(rng, time)
        start = np.array([*rng.uniform(-0.2, 0.2, 2), rng.uniform(-np.pi, np.pi)])
        path = paths(self.ground, [Drive(time, phi, time, start)])[0]
        seen = np.arange(int(self.film_s * FRAMES_PER_SECOND)) / FRAMES_PER_SECOND
        at = np.clip(np.round((SPIN_UP_S + seen) * STEPS_PER_SECOND).astype(int), 0, len(time) - 1)
        points = vertices(phi[at], path[at])
        return time[at] - SPIN_UP_S, points + rng.normal(0, NOISE, points.shape)


def bending(rng: np.random.Generator, time: Floats) -> Floats:
    """Joint angles (n + 1, 10): a wave from head to tail, growing towards the tail."""
    frequency, waves, amplitude = rng.uniform(0.9, 1.3), rng.uniform(0.8, 1.2), rng.uniform(0.4, 0.6)
    back = np.arange(JOINTS)[::-1] / (JOINTS - 1)  # 0 at the head

    def wander(size: float) -> Floats:
        rates, phases = rng.uniform(0.05, 0.2, 3), rng.uniform(0, 2 * np.pi, 3)
        return size * np.sin(2 * np.pi * rates * time[:, None] + phases).mean(axis=1)

    cycles = frequency * time + wander(0.5)
    wave = np.sin(2 * np.pi * (cycles[:, None] - waves * back))
    return amplitude * (1 + wander(0.4))[:, None] * (0.6 + 0.4 * back) * wave + wander(0.15)[:, None]


def write(swimmer: Swimmer, folder: Path) -> Path:
    """An ordinary campaign folder that knows nothing but points."""
    folder.mkdir(parents=True, exist_ok=True)
    time, points = swimmer.film()
    rows = np.column_stack([time, points.reshape(len(time), -1)])
    header = "t_s," + ",".join(f"x_{k},y_{k}" for k in range(VERTICES))
    np.savetxt(folder / "motion.csv", rows, fmt="%.6f", delimiter=",", header=header, comments="")

    def numbers(values: Floats) -> str:
        return "[" + ", ".join(f"{v:.6g}" for v in values) + "]"

    lines = ["format = 1", 'name = "swimmer"', "", "[body]", f"vertices = {VERTICES}"]
    lines += [f"edge_lengths = {numbers(EDGES)}", f"weights = {numbers(WEIGHTS)}", ""]
    lines += ["[motion]", 'format = "tidy"', 'length_unit = "m"', "", "[[trial]]", 'name = "swim"']
    lines += ['motion = "motion.csv"', ""]
    (folder / "campaign.toml").write_text("\n".join(lines))
    return folder


def fins(rng: np.random.Generator) -> ExternalForce:
    """Fins that row: a push along the body, in strokes of their own."""
    pull, rate, phase = rng.uniform(0.05, 0.15), rng.uniform(1.5, 3.0), rng.uniform(0, 2 * np.pi)

    def force(p: Floats, time: Floats) -> Floats:
        axis = p[:, -1] - p[:, 0]
        axis /= np.linalg.norm(axis, axis=1, keepdims=True)
        stroke = pull * (1 + np.sin(2 * np.pi * rate * time + phase))
        return WEIGHTS[:, None] * (stroke[:, None] * axis)[:, None]

    return force


def pulses(rng: np.random.Generator) -> ExternalForce:
    """A push that comes and goes, always the same way across the tank."""
    pull, rate, phase = rng.uniform(0.05, 0.15), rng.uniform(0.4, 2.0), rng.uniform(0, 2 * np.pi)
    angle = rng.uniform(0, 2 * np.pi)
    direction = pull * np.array([np.cos(angle), np.sin(angle)])

    def force(p: Floats, time: Floats) -> Floats:
        return np.sin(2 * np.pi * rate * time + phase)[:, None, None] * WEIGHTS[:, None] * direction + 0 * p

    return force


def current(rng: np.random.Generator) -> ExternalForce:
    """Water that flows, now this way and now that."""
    pull, turn, phase = rng.uniform(0.05, 0.15), rng.uniform(0.1, 0.4), rng.uniform(0, 2 * np.pi)

    def force(p: Floats, time: Floats) -> Floats:
        angle = 2 * np.pi * turn * time + phase
        direction = pull * np.column_stack([np.cos(angle), np.sin(1.7 * angle)])
        return WEIGHTS[:, None] * direction[:, None] + 0 * p

    return force


OUTSIDE: dict[str, Callable[[np.random.Generator], ExternalForce]] = {
    "fins": fins,
    "pulses": pulses,
    "current": current,
}
