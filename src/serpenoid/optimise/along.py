"""Constraints on where the body is in every row: functions of one pose and one shape, mapped over the cycle.

    gaps(vertices of row t in the world) >= margin      t = 0 .. T (of a closed gait, row T has the first shape again)

Legend: T steps, R rows, s coordinates of a shape, c gaps per row.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from serpenoid.mechanics import energy, kinematics
from serpenoid.mechanics.compile import compiled
from serpenoid.mechanics.functions import CSE, split_parameters
from serpenoid.model import Structure
from serpenoid.objectives.criteria import Gaps
from serpenoid.optimise.assembly import Scatter, scatter
from serpenoid.optimise.blocks import Cycle, over


def gaps_function(gaps: list[Gaps], structure: Structure) -> ca.Function:
    """Vertices (2, N) in the world to all gaps (c)."""
    points = ca.SX.sym("points", 2, structure.vertices)
    return ca.Function("gaps", [points], [ca.densify(ca.vertcat(*(gap(points) for gap in gaps)))])


@dataclass(frozen=True)
class Along:
    """The gaps of all rows with derivatives by poses and shapes."""

    gaps: tuple[Gaps, ...]
    structure: Structure
    steps: int
    rows: int
    coordinates: int
    serpenoid: bool
    portable: bool = False

    @cached_property
    def _functions(self) -> tuple[ca.Function, ca.Function, ca.Function]:
        g, a = ca.SX.sym("g", 3), ca.SX.sym("a", self.coordinates)
        parameters = ca.SX.sym("parameters", 2 * self.structure.vertices)
        edges, weights, _ = split_parameters(parameters, self.structure)
        angles = kinematics.serpenoid_joint_angles(a, edges, self.structure) if self.serpenoid else a
        points, _ = kinematics.vertices(angles, edges, weights, self.structure)
        world = energy.planar_rotation(g[2]) @ points + ca.repmat(g[:2], 1, self.structure.vertices)
        value = gaps_function(list(self.gaps), self.structure)(world)
        z, multipliers = ca.vertcat(g, a), ca.SX.sym("multipliers", value.numel())
        hessian, gradient = ca.hessian(ca.dot(multipliers, value), z)
        inputs = [g, a, parameters]
        made = [
            ca.Function("along_value", inputs, [value], CSE),
            ca.Function("along_jacobian", inputs, [ca.densify(ca.jacobian(value, z))], CSE),
            ca.Function("along_hessian", [*inputs, multipliers], [ca.densify(gradient), ca.densify(hessian)], CSE),
        ]
        first, second, third = made if self.portable else compiled(made)
        return first, second, third

    @property
    def count(self) -> int:
        """c."""
        return int(self._functions[0].size1_out(0))

    @property
    def total(self) -> int:
        """Gaps of all rows."""
        return self.count * (self.steps + 1)

    def value(self, cycle: Cycle) -> ca.MX:
        """All gaps, row by row."""
        return ca.vec(self._over(self._functions[0], cycle))

    def jacobian(self, cycle: Cycle) -> tuple[ca.MX, ca.MX]:
        """Derivatives by poses and by shapes."""
        blocks = self._over(self._functions[1], cycle)
        return self._jacobian_places[0](blocks), self._jacobian_places[1](blocks)

    def hessian(self, cycle: Cycle, multipliers: ca.MX) -> tuple[ca.MX, ca.MX, ca.MX, ca.MX]:
        """Force on the shapes (s, R); Hessian blocks poses by poses (upper), poses by shapes, shapes by shapes."""
        columns = ca.reshape(multipliers, self.count, self.steps + 1)
        gradient, blocks = self._over(self._functions[2], cycle, columns)
        force = ca.reshape(ca.densify(self._force_places(gradient)), self.coordinates, self.rows)
        uu, uq, qq = (places(blocks) for places in self._hessian_places)
        return force, uu, uq, qq

    def _over(self, function: ca.Function, cycle: Cycle, *more: ca.MX) -> ca.MX:
        shapes = ca.horzcat(cycle.shapes, cycle.shapes[:, 0]) if cycle.closed else cycle.shapes
        return over(function, self.steps + 1, [2], cycle.poses, shapes, cycle.parameters, *more)

    @cached_property
    def _columns(self) -> tuple[np.ndarray, np.ndarray]:
        """Pose and shape columns of the local variables of every row, shape (T + 1, 3 + s); -1: the other group."""
        t, s = np.arange(self.steps + 1)[:, None], self.coordinates
        poses = 3 * (t - 1) + np.arange(3)
        poses[0] = -1
        none = np.full((self.steps + 1, 3), -1)
        return np.hstack([poses, np.full((len(t), s), -1)]), np.hstack([none, s * (t % self.rows) + np.arange(s)])

    @cached_property
    def _jacobian_places(self) -> tuple[Scatter, Scatter]:
        t, j, i = np.meshgrid(
            *(np.arange(n) for n in (self.steps + 1, 3 + self.coordinates, self.count)), indexing="ij"
        )
        poses, shapes = self._columns[0][t, j], self._columns[1][t, j]
        rows, sizes = self.count * t + i, (3 * self.steps, self.coordinates * self.rows, 0)
        return (
            scatter(rows, poses, poses >= 0, (self.total, sizes[0])),
            scatter(rows, shapes, shapes >= 0, (self.total, sizes[1])),
        )

    @cached_property
    def _force_places(self) -> Scatter:
        shapes = self._columns[1]
        return scatter(shapes, np.zeros_like(shapes), shapes >= 0, (self.coordinates * self.rows, 1))

    @cached_property
    def _hessian_places(self) -> tuple[Scatter, Scatter, Scatter]:
        n, g, a = 3 + self.coordinates, 3 * self.steps, self.coordinates * self.rows
        t, j, i = np.meshgrid(*(np.arange(k) for k in (self.steps + 1, n, n)), indexing="ij")
        (pi, pj), (si, sj) = ((c[t, i], c[t, j]) for c in self._columns)
        return (
            scatter(pi, pj, (pi >= 0) & (pj >= pi), (g, g)),
            scatter(pi, sj, (pi >= 0) & (sj >= 0), (g, a)),
            scatter(si, sj, (si >= 0) & (sj >= 0), (a, a)),
        )
