"""Simulate what a problem file describes."""

from __future__ import annotations

from dataclasses import dataclass

from serpenoid.body import Floats
from serpenoid.gaits import EllipseGait
from serpenoid.gaits.table import read_table
from serpenoid.mechanics.tables import joint_table
from serpenoid.problem import Problem
from serpenoid.simulation.rollout import simulate_joint_angles
from serpenoid.trajectory import Trajectory


@dataclass(frozen=True)
class Simulation:
    """A problem's gait as joint table (T, m) [rad] and its motion over `task.cycles` cycles."""

    problem: Problem
    table: Floats
    trajectory: Trajectory


def gait_table(problem: Problem) -> Floats:
    """Joint table of the problem's gait, shape (T, m) [rad]."""
    if isinstance(problem.gait, EllipseGait):
        return joint_table(problem.model, problem.gait.parameters, problem.task.steps)
    return read_table(problem.folder / problem.gait.path, problem.body.joint_count)


def simulate(problem: Problem) -> Simulation:
    """Simulate the gait of a problem."""
    table = gait_table(problem)
    return Simulation(problem, table, simulate_joint_angles(problem.model, table, problem.task.cycles))
