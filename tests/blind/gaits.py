"""The gaits of a campaign: serpenoid ellipses within the robot's limits, the first one moving tail first."""

from __future__ import annotations

import numpy as np

from blind.ground import Ground
from blind.motion import Drive, paths
from blind.schedule import Plan, grid
from blind.snake import SNAKE10, Floats, Robot
from oracle.chain import serpenoid_joint_table

ROWS = 50
LEAST_DISPLACEMENT = 0.1  # body lengths a cycle


def progress(table: Floats, eps: float = 0.2, robot: Robot = SNAKE10) -> float:
    """Displacement along the mean heading over one cycle [body lengths]; positive = head first."""
    g = grid(Plan(table, 1.0, 0.0, 1), 100)
    path = paths(Ground(eps, robot), [Drive(g.time, g.setpoint, g.phase, np.zeros(3))])[0]
    heading = path[:, 2].mean()
    return float(path[-1, :2] @ [np.cos(heading), np.sin(heading)]) / robot.length


def random_table(rng: np.random.Generator, direction: int, fastest_cycle_s: float) -> Floats:
    """A random gait that keeps the limits and gets somewhere: head first (+1) or tail first (-1)."""
    for _ in range(1000):
        shape = {
            "sigma": direction * rng.uniform(0.35, 1.0),
            "a": rng.uniform(3.5, 7.5),
            "xi": rng.uniform(0.75, 1.5),
            "x_c": rng.uniform(-2, 2),
            "y_c": rng.uniform(-2, 2),
            "theta": rng.uniform(-np.pi, np.pi),
        }
        table = np.round(serpenoid_joint_table(SNAKE10.edges, ROWS, **shape), 6)
        speed = np.abs(np.diff(table, axis=0, append=table[:1])).max() * ROWS / fastest_cycle_s
        if np.abs(table).max() > SNAKE10.joint_limit or speed > 0.8 * SNAKE10.speed_limit:
            continue
        if direction * progress(table) > LEAST_DISPLACEMENT:
            return table
    raise ArithmeticError("no gait within the limits in 1000 draws")
