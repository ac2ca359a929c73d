"""Gaits and short runs for the arena's tests; the joint tables are computed here, from the formula in the paper."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from serpenoid.arena.assembly import Assembly
from serpenoid.arena.robot import Robot
from serpenoid.arena.world import World

ROBOT = Robot()
LENGTH = float(ROBOT.edge_lengths_m.sum())


def serpenoid_table(a=6.0, sigma=1.0, xi=1.0, rows=50, theta=0.0, centre=(0.0, 0.0)):
    """Joint angles (rows, 10): edge angle = integral of kappa at the edge's midpoint, joint = their difference."""
    edges = ROBOT.edge_lengths_m / LENGTH
    middle, k = np.cumsum(edges) - edges / 2, 2 * np.pi * xi
    phase = 2 * np.pi * np.arange(rows)[:, None] / rows
    u, v, c, s = a * np.cos(phase), a * sigma * np.sin(phase), np.cos(theta), np.sin(theta)
    w1, w2 = c * u - s * v + centre[0], s * u + c * v + centre[1]
    return np.diff((w1 * (1 - np.cos(k * middle)) + w2 * np.sin(k * middle)) / k, axis=1)


@dataclass
class Run:
    forward: float  # body lengths along the start chord, per cycle
    left: float
    paths: np.ndarray  # (rows * cycles + 1, 12, 2)
    readings: np.ndarray  # (rows * cycles, 10)
    power: np.ndarray
    world: World


def run(assembly=None, table=None, duration=5.0, cycles=1):
    """Play `table` without pauses on even mats and measure the mass centre's motion."""
    assembly = assembly or Assembly.healthy(ROBOT)
    table = serpenoid_table() if table is None else table
    world = World(assembly)
    world.place(table[0])
    paths, readings, power = [world.markers()[:, :2]], [], []
    for count in range(cycles * len(table)):
        world.command(table[count % len(table)])
        while world.time_s < (count + 1) * duration / len(table) - 1e-9:
            world.step()
            power.append(world.power())
        paths.append(world.markers()[:, :2])
        readings.append(world.angles())
    paths = np.array(paths)
    weights = ROBOT.vertex_masses_kg / ROBOT.mass_kg
    moved = weights @ (paths[-1] - paths[0]) / LENGTH / cycles
    chord = paths[0, -1] - paths[0, 0]
    ahead = chord / np.linalg.norm(chord)
    forward, left = moved @ ahead, ahead[0] * moved[1] - ahead[1] * moved[0]
    return Run(forward, left, paths, np.array(readings), np.array(power), world)
