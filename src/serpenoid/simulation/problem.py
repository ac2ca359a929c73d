"""Simulate what a problem file describes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
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
from serpenoid.simulation.gaits import simulate_gait
from serpenoid.simulation.lifted import simulate_lifted
from serpenoid.simulation.mesh import FACTORS, FINER, MeshStudy, study_mesh
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
        """The problem, and how far it went; limits of its joints that it breaks, units that may be others, steps that
        are too coarse."""
        told = self.trajectory.odd_units
        doubts = [*self.problem.odd_units, *broken_limits(self.problem, self.table)]
        if self.mesh is not None and self.mesh.too_coarse:
            doubts.append(f"{self.mesh.too_coarse}: {more_steps(self.problem, FINER * self.mesh.steps)}")
        broken = [said for said in doubts if said not in told]
        return warned(f"{self.problem.name}: {self.trajectory.summary()}", broken)

    @cached_property
    def mesh(self) -> MeshStudy | None:
        """How one cycle depends on the number of steps: simulated with more as it is asked for; None of no motion."""
        if not self.trajectory.status.ok:
            return None
        return mesh_of(self.problem, self.table, on_meshes(self.problem, self.table))


def more_steps(problem: Problem, steps: int, ask: str = "ask for ") -> str:
    """How to have so many steps; ask: begins what a caller, or a command, says of them."""
    given = isinstance(problem.gait, TableGait)
    return f"give a joint table of {steps} rows a cycle" if given else f"{ask}task.steps={steps}"


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


def on_meshes(problem: Problem, table: Floats) -> list[Trajectory]:
    """The motions of the problem's gait, whose joint table is known, with FACTORS times as many steps."""
    return [simulate_gait(problem.model, *finer_gait(problem, table, factor)) for factor in FACTORS]


def mesh_of(problem: Problem, table: Floats, meshes: Sequence[Trajectory]) -> MeshStudy:
    """How the motion depends on the number of steps; meshes: see `on_meshes`."""
    return study_mesh(meshes, len(table) - problem.task.transient)


def finer_gait(problem: Problem, table: Floats, factor: int) -> tuple[GaitFamily, Floats]:
    """The problem's gait with `factor` times as many steps: its family, and its parameters there."""
    family = problem.family_of()
    if isinstance(problem.gait, TableGait):  # of a file, which has its own number of rows
        family = TableGait.from_angles(table).of(table.shape[1], len(table), closed=not problem.task.transient)
    return family.refined(factor), family.on_finer_rows(family.start(), factor)
