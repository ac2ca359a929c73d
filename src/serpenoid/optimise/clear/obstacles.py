"""Obstacles of a task as numbers: motions between rows, what an NLP watches, what is proven of the answer."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from serpenoid.body import Floats
from serpenoid.gaits import GaitFamily
from serpenoid.mechanics.tables import family_tables
from serpenoid.model import Model
from serpenoid.objectives.criteria import Gaps
from serpenoid.optimise.clear.between import Between, GapField
from serpenoid.optimise.clear.clearance import Clearance, clearance
from serpenoid.optimise.clear.watch import Watch, every_vertex, exchanged, near
from serpenoid.simulation.rollout import Batch
from serpenoid.simulation.servos import realise_gait
from serpenoid.trajectory import Trajectory

FEASIBLE = 1e-9  # body lengths


@dataclass(frozen=True)
class Obstacles:
    """What must be kept clear of by gaits of `steps` steps; none where `gaps` is empty."""

    gaps: tuple[Gaps, ...]
    model: Model
    steps: int
    closed: bool

    @cached_property
    def field(self) -> GapField:
        """The gaps of single points."""
        return GapField(self.gaps)

    @property
    def columns(self) -> int:
        """Gaps of a point."""
        return int(self.field.convex.size)

    def path(self, poses: Floats, tables: Floats) -> Between:
        """Motions with poses (B, T + 1, 3) of joint tables (B, R, m)."""
        if not self.closed:
            return Between(self.model, poses, tables)
        angles = np.array([realise_gait(self.model, table) for table in tables])
        return Between(self.model, poses, np.concatenate([angles, angles[:, :1]], axis=1))

    def first(self) -> Watch:
        """What the first NLP watches."""
        return every_vertex(self.steps, self.model.structure.vertices, self.columns) if self.gaps else Watch()

    def near(self, poses: Floats, table: Floats) -> Watch:
        """Of all vertices in all rows of a motion, what is near an obstacle."""
        return near(self.first(), self.path(poses[None], table[None]), self.field)

    def after(self, watch: Watch, poses: Floats, table: Floats) -> Watch:
        """What the next NLP watches."""
        return exchanged(watch, self.path(poses[None], table[None]), self.field)

    def clearance(self, poses: Floats, table: Floats) -> Clearance | None:
        """How near a motion comes to obstacles at any time, None where there are none."""
        if not self.gaps:
            return None
        return clearance(self.path(poses[None], table[None]), self.field)

    def of_gait(self, family: GaitFamily, q: Floats, motion: Trajectory) -> Clearance | None:
        """The same of a gait's simulated motion; None where the simulation failed, too."""
        if not self.gaps or not motion.status.ok:
            return None
        return self.clearance(motion.poses, family_tables(self.model, family, q[None])[0])

    def too_near(self, watch: Watch, tables: Floats, batch: Batch, margin: float) -> Floats:
        """How much nearer than `margin` watched points come, and vertices of any row than allowed, summed: (B,)."""
        if not self.gaps:
            return np.zeros(len(tables))
        path, slack = self.path(batch.poses, tables), FEASIBLE
        watched = watch.values(path, self.field) if watch.points else np.zeros((len(tables), 0))
        vertices = self.field.at(path.vertices.reshape(-1, 2))[0].reshape(len(tables), -1)
        excess = np.maximum(margin - slack - watched, 0).sum(1) + np.maximum(-slack - vertices, 0).sum(1)
        return np.asarray(excess)
