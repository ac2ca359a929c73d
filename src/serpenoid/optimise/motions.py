"""What gaits do, by forward simulation: for starts, certificates and searches, without an NLP.

Legend: T steps, R rows, m joints, q gait parameters (n,), B gaits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from serpenoid.body import Floats
from serpenoid.gaits import Gait
from serpenoid.mechanics.tables import family_tables
from serpenoid.optimise.asked import Customise, asked
from serpenoid.optimise.clear.clearance import Clearance
from serpenoid.optimise.clear.obstacles import Obstacles
from serpenoid.optimise.ipopt import Point
from serpenoid.optimise.program.limits import path_limits, violations
from serpenoid.optimise.solution import CaseOutcome, SelfClear
from serpenoid.optimise.step.motion_law import needs_states
from serpenoid.optimise.step.played import Played
from serpenoid.problem import Problem
from serpenoid.simulation.gaits import simulate_gait, simulate_gaits
from serpenoid.simulation.mesh import FACTORS, FINER, MeshStudy, study_mesh
from serpenoid.simulation.problem import gait_parameters
from serpenoid.simulation.rollout import Batch
from serpenoid.trajectory import Trajectory

GaitBounds = tuple[Floats, Floats]


@dataclass(frozen=True)
class Costs:
    """value: objectives (B,); outside: sums of the violations (B,); sound: whether gaits could be simulated (B,)."""

    value: Floats
    outside: Floats
    sound: np.ndarray
    batch: Batch | None = None


class GaitMotions:
    """The gaits of a problem's family (or of that of `gait`), what is asked of them, and what they do."""

    def __init__(self, problem: Problem, customise: Customise | None = None, gait: Gait | None = None) -> None:
        self.problem, self.model = problem, problem.model
        self.family = problem.family_of(gait)
        self.steps = self.family.rows - (not self.family.closed)
        self.asked = asked(problem.task, self.family, customise, self.model)
        self.limits = path_limits(problem)
        gaps = tuple(self.asked.criteria.clear_of)
        self.obstacles = Obstacles(gaps, self.model, self.steps, self.family.closed)

    def gait_bounds(self) -> GaitBounds:
        """Lower and upper bounds of q: the problem's; joint limits too where the parameters are the angles."""
        lower, upper = self.family.limits
        if self.family.free:
            m, rows = self.family.joints, self.family.rows
            lower = np.maximum(lower, np.tile(self.limits.lower[:m], rows))
            upper = np.minimum(upper, np.tile(self.limits.upper[:m], rows))
        return lower, upper

    def own_start(self) -> Floats:
        """The problem's gait, inside the bounds."""
        return np.clip(gait_parameters(self.problem, self.family), *self.gait_bounds())

    def table(self, q: Floats) -> Floats:
        """Joint table (R, m) of gait parameters q."""
        return family_tables(self.model, self.family, q[None])[0]

    def tables(self, gaits: Floats) -> Floats:
        """Joint tables (B, R, m) of gaits (B, n)."""
        return family_tables(self.model, self.family, gaits)

    def simulate(self, q: Floats, factor: int = 1) -> Trajectory:
        """The motion of gait q, with `factor` times as many steps."""
        if factor == 1:
            return simulate_gait(self.model, self.family, q)
        return simulate_gait(self.model, self.family.refined(factor), self.family.on_finer_rows(q, factor))

    def batch(self, gaits: Floats, tables: Floats) -> Batch:
        """The motions of gaits (B, n) with these tables (B, R, m)."""
        return simulate_gaits(self.model, self.family, gaits, tables)

    def costs(self, tables: Floats, gaits: Floats, c: float) -> Costs:
        """Objective, violations of what is asked, and soundness of gaits (B, n) with these tables, simulated."""
        batch = self.batch(gaits, tables)
        value, outside = self.asked.evaluate(batch, tables, gaits, c)
        target = self.heading_target()
        if target is not None:
            outside = outside + np.abs(batch.poses[:, -1, 2] - target)
        return Costs(value, outside, batch.sound, batch)

    def value(self, q: Floats, table: Floats, trajectory: Trajectory, c: float) -> float:
        """The objective of a simulated gait; not a number where the simulation failed, or what is asked is none."""
        poses, dissipation = trajectory.poses[None], np.array([trajectory.dissipation])
        batch = Batch(poses, dissipation, np.array([trajectory.residual]), np.array([trajectory.status.ok]))
        value, outside = self.asked.evaluate(batch, table[None], q[None], c)
        return float(value[0]) if not np.isnan(outside[0]) else np.nan

    def pose_error(self, point: Point, trajectory: Trajectory) -> float:
        """Largest difference between the poses of the NLP and those of the simulation."""
        poses = point.x[: self.family.pose_size * self.steps].reshape(self.steps, -1)
        return float(np.max(np.abs(trajectory.poses[1:] - poses)))

    def on_meshes(self, q: Floats) -> list[Trajectory]:
        """The motions of gait q with FACTORS times as many steps."""
        return [self.simulate(q, factor) for factor in FACTORS]

    def mesh_studies(self, q: Floats, meshes: Sequence[Trajectory]) -> list[MeshStudy]:
        """How the motion depends on the number of steps; meshes: `on_meshes` of q."""
        return [study_mesh(meshes, self.steps)]

    def outcomes(self, q: Floats, c: float) -> tuple[CaseOutcome, ...]:
        """What gait q does in every case that it must serve; of one model: nothing more to say."""
        return ()

    def fine_clearance(self, q: Floats, finest: Trajectory) -> Clearance | None:
        """How near the body comes to obstacles with FINER times as many steps, in the last of `on_meshes`; None without
        any, or where that failed."""
        return self.obstacles.of_gait(self.family.refined(FINER), self.family.on_finer_rows(q, FINER), finest)

    def self_clearance(self, table: Floats) -> SelfClear | None:
        """How near the body comes to itself; None where nobody asks."""
        return None

    def excess(self, tables: Floats) -> Floats:
        """How far joint angles and their changes exceed the limits, shape (..., rows, 2 m); -infinity without any."""
        return violations(tables, self.limits, self.family.closed)

    def start(self, q: Floats) -> Floats:
        """A start that satisfies all momentum equations: the simulated poses of gait q."""
        trajectory = self.simulate(q)
        poses = np.nan_to_num(trajectory.poses[1:] - trajectory.poses[0])
        priced = [] if self.asked.separable else [trajectory.dissipation]
        states = np.zeros(0) if self._played is None else self._played.start(self.table(q))
        return np.concatenate([poses.ravel(), np.nan_to_num(priced), states, q])

    @property
    def states(self) -> int:
        """Numbers of the servos' memories in the NLP."""
        return 0 if self._played is None else self._played.states

    @property
    def own(self) -> int:
        """Numbers of the NLP's variables before the gait's parameters."""
        return self.family.pose_size * self.steps + (not self.asked.separable) + self.states

    @cached_property
    def _played(self) -> Played | None:
        """Servos whose memories are variables of the NLP."""
        return Played(self.model, self.family) if needs_states(self.model, self.family) else None

    def heading_target(self) -> float | None:
        """Prescribed heading change [rad], None where it is free."""
        constraints = self.problem.task.constraints
        return 0.0 if constraints.straight else constraints.heading_change_rad
