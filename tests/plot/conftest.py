"""A motion made without the simulator: a wave that travels along a straight path and turns a little."""

from pathlib import Path

import numpy as np
import pytest

from serpenoid import group
from serpenoid.plot.family import Family
from serpenoid.problem import Problem, load
from serpenoid.status import Status
from serpenoid.trajectory import Trajectory

STEPS, VERTICES, TURN = 20, 12, 0.3
PROBLEMS = Path(__file__).parents[2] / "problems"


@pytest.fixture(scope="session")
def problem() -> Problem:
    return load(PROBLEMS / "snake10.toml", ["task.steps=20"])


@pytest.fixture(scope="session")
def trajectory() -> Trajectory:
    phase, s = np.arange(STEPS + 1) / STEPS, np.linspace(0, 1, VERTICES)
    waves = 0.12 * np.sin(2 * np.pi * (s[None] + phase[:, None]))
    shapes = np.stack([np.tile(0.85 * (s - 0.5), (STEPS + 1, 1)), waves - waves.mean(1, keepdims=True)], -1)
    shapes -= shapes.mean(1, keepdims=True)
    poses = np.column_stack([0.5 * phase, 0.02 * np.sin(2 * np.pi * phase), 0.1 + TURN * phase])
    return Trajectory(Status.SOLVED, poses, group.place(poses, shapes), np.full(STEPS, 0.01), 0.0, STEPS)


@pytest.fixture(scope="session")
def table() -> np.ndarray:
    phase = np.arange(STEPS)[:, None] / STEPS
    return 0.6 * np.sin(2 * np.pi * (phase + np.arange(10) / 10))


@pytest.fixture(scope="session")
def family() -> Family:
    """Delta = 1 - x^2 / 2, D = (1 - x)^2 / 2 with the x that minimises -Delta + c D: an exact family of optima."""
    c = np.linspace(0, 2.5, 26)
    x = c / (1 + c)
    gaits = np.column_stack([0.4 + 0.2 * c, 0 * c, 0 * c, 2 + 0 * c, 8 - c, 0.8 + 0.1 * c])
    return Family(c, 1 - x**2 / 2, (1 - x) ** 2 / 2, gaits)
