"""Simulate what a problem file describes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.gaits import GaitFamily, TableGait
from serpenoid.gaits.lifted import LiftedFamily
from serpenoid.joint_limits import broken_limits
from serpenoid.mechanics.tables import family_tables
from serpenoid.problem import Problem
from serpenoid.shown import Shown
from serpenoid.simulation.callers import problem_of
from serpenoid.simulation.lifted import simulate_lifted
from serpenoid.simulation.rollout import simulate_joint_angles
from serpenoid.table_file import read_table
from serpenoid.trajectory import Trajectory
from serpenoid.wording import warned


@dataclass(frozen=True, repr=False, eq=False)
class Simulation(Shown):
    """A problem's gait as joint table (T, m) [rad] and its motion over `task.cycles` cycles."""

    problem: Problem
    table: Floats
    trajectory: Trajectory

    def summary(self) -> str:
        """The problem, and how far it went; limits of its joints that it breaks, units that may be others."""
        told = self.trajectory.odd_units
        doubts = [*self.problem.odd_units, *broken_limits(self.problem, self.table)]
        broken = [said for said in doubts if said not in told]
        return warned(f"{self.problem.name}: {self.trajectory.summary()}", broken)


def gait_table(problem: Problem) -> Floats:
    """Joint table of the problem's gait, shape (R, m) [rad]."""
    gait = problem.gait
    if isinstance(gait, TableGait) and gait.path is not None:
        with problem.named_by("[gait] path"):
            return read_table(problem.folder / gait.path, problem.body.joint_count)
    family = problem.family_of()
    return family_tables(problem.model, family, family.start()[None])[0]


def gait_parameters(problem: Problem, family: GaitFamily) -> Floats:
    """Parameters (n,) of the problem's gait in its family; a table may stand in a file."""
    gait = family.like
    if isinstance(gait, TableGait) and gait.path is not None:
        with problem.named_by("[gait] path"):
            table = read_table(problem.folder / gait.path, family.joints)
        if len(table) != family.rows:
            raise InputError(f"{gait.path}: needs {family.rows} rows to start from, got {len(table)}. Set task.steps.")
        return table.ravel()
    return family.start()


def simulate(problem: Problem | str | Path) -> Simulation:
    """Simulate the gait of a problem (or its file); with `[lift]` in space, in the middle of its `phase` and `bias`."""
    problem = problem_of(problem)
    table, task, family = gait_table(problem), problem.task, problem.family_of()
    if isinstance(family, LiftedFamily):
        lifted = simulate_lifted(problem.model, family, family.start(), task.cycles)
        return Simulation(problem, table, lifted)
    motion = simulate_joint_angles(problem.model, table, task.cycles, closed=not task.transient)
    return Simulation(problem, table, motion)
