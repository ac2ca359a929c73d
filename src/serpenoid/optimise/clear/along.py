"""Gaps to obstacles in the NLP: functions of the poses and shapes before and after each watched instant.

    gaps(point at `place` behind every vertex, at `share` of the way from row t to row t + 1) >= margin

At rows (share 0) one pose and one shape are asked, between them two; joints turn at constant rates and the frame moves
evenly. Legend: T steps, R rows, N vertices, s coordinates of a shape, I instants, c gaps of an instant.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import casadi as ca
import numpy as np

from serpenoid.mechanics import energy, kinematics
from serpenoid.mechanics.functions import CSE, split_parameters
from serpenoid.mechanics.wide import Columns, over_columns
from serpenoid.model import Structure
from serpenoid.objectives.criteria import Gaps
from serpenoid.optimise.clear.watch import Watch
from serpenoid.optimise.step.assembly import Scatter, Scatters, scatter
from serpenoid.optimise.step.blocks import Cycle

Functions = tuple[Columns, Columns, Columns]


@lru_cache(maxsize=16)
def gap_functions(
    gaps: tuple[Gaps, ...], structure: Structure, coordinates: int, serpenoid: bool, portable: bool
) -> GapFunctions:
    """Functions of instants, kept for as long as the same gaps are asked for."""
    return GapFunctions(gaps, structure, coordinates, serpenoid, portable)


@dataclass(frozen=True)
class GapFunctions:
    """value, Jacobian, (gradient, Hessian) of one instant by z = (poses, shapes)."""

    gaps: tuple[Gaps, ...]
    structure: Structure
    coordinates: int
    serpenoid: bool
    portable: bool

    @cached_property
    def at_rows(self) -> Functions:
        """Of one pose and one shape."""
        return self._of(1)

    @cached_property
    def between(self) -> Functions:
        """Of the poses and shapes before and after."""
        return self._of(2)

    def _of(self, ends: int) -> Functions:
        s, n = self.coordinates, self.structure.vertices
        g, a, when = ca.SX.sym("g", 3, ends), ca.SX.sym("a", s, ends), ca.SX.sym("when", 2)
        parameters = ca.SX.sym("parameters", 2 * n)
        value = self._value(g, a, when, parameters)
        z, multipliers = ca.vertcat(ca.vec(g), ca.vec(a)), ca.SX.sym("multipliers", value.numel())
        hessian, gradient = ca.hessian(ca.dot(multipliers, value), z)
        inputs = [ca.vec(g), ca.vec(a), when, parameters]
        made = [
            ca.Function("along_value", inputs, [value], CSE),
            ca.Function("along_jacobian", inputs, [ca.densify(ca.jacobian(value, z))], CSE),
            ca.Function("along_hessian", [*inputs, multipliers], [ca.densify(gradient), ca.densify(hessian)], CSE),
        ]
        first, second, third = over_columns(made, shared=3, portable=self.portable)
        return first, second, third

    def _value(self, g: ca.SX, a: ca.SX, when: ca.SX, parameters: ca.SX) -> ca.SX:
        """Gaps point by point; when: share of the step, place behind each vertex."""
        edges, weights, _ = split_parameters(parameters, self.structure)
        rows = ca.horzsplit(a)
        if self.serpenoid:
            rows = [kinematics.serpenoid_joint_angles(row, edges, self.structure) for row in rows]
        angles, pose = (_mixed(ends, when[0]) for ends in (rows, ca.horzsplit(g)))
        body, _ = kinematics.vertices(angles, edges, weights, self.structure)
        world = energy.placed(pose, body)
        world += when[1] * (ca.horzcat(world[:, 1:], world[:, -1]) - world)
        return ca.densify(ca.vertcat(*(gap.of(point) for point in ca.horzsplit(world) for gap in self.gaps)))


def _mixed(rows: list[ca.SX], share: ca.SX) -> ca.SX:
    return rows[0] if len(rows) == 1 else (1 - share) * rows[0] + share * rows[1]


@dataclass(frozen=True)
class _Group:
    """Instants of one kind: at rows (`ends` 1) or between them (2)."""

    functions: Functions
    ends: int
    instants: tuple[tuple[float, int, float], ...]
    steps: int
    rows: int
    coordinates: int

    @property
    def count(self) -> int:
        """c."""
        return int(self.functions[0].function.size1_out(0))

    @property
    def total(self) -> int:
        """Gaps of all instants."""
        return self.count * len(self.instants)

    def over(self, function: Columns, cycle: Cycle, *more: ca.MX) -> ca.MX:
        """`function` at all instants."""
        poses = ca.vertcat(*(cycle.poses[:, (self._at + end).tolist()] for end in range(self.ends)))
        shapes = ca.vertcat(*(cycle.shapes[:, ((self._at + end) % self.rows).tolist()] for end in range(self.ends)))
        when = ca.DM([[share, place] for share, _, place in self.instants]).T
        return function(len(self.instants), poses, shapes, ca.MX(when), cycle.parameters, *more)

    @cached_property
    def _at(self) -> np.ndarray:
        return np.array([step for _, step, _ in self.instants], int)

    @cached_property
    def columns(self) -> tuple[np.ndarray, np.ndarray]:
        """Pose and shape columns of z at every instant, shape (I, (3 + s) ends); -1: of the other group, or fixed."""
        s, at = self.coordinates, self._at[:, None] + np.arange(self.ends)
        poses = (3 * (at - 1)[..., None] + np.arange(3)).reshape(len(at), -1)
        shapes = (s * (at % self.rows)[..., None] + np.arange(s)).reshape(len(at), -1)
        return (
            np.hstack([np.where(poses < 0, -1, poses), np.full(shapes.shape, -1)]),
            np.hstack([np.full(poses.shape, -1), shapes]),
        )

    @cached_property
    def jacobian_places(self) -> tuple[Scatter, Scatter]:
        """Of Jacobian blocks, by poses and by shapes."""
        z = (3 + self.coordinates) * self.ends
        t, j, i = np.meshgrid(*(np.arange(n) for n in (len(self.instants), z, self.count)), indexing="ij")
        rows, sizes = self.count * t + i, (3 * self.steps, self.coordinates * self.rows)
        first, second = (
            scatter(rows, columns[t, j], columns[t, j] >= 0, (self.total, size))
            for columns, size in zip(self.columns, sizes, strict=True)
        )
        return first, second

    @cached_property
    def force_places(self) -> Scatter:
        """Of gradients, by shapes."""
        shapes = self.columns[1]
        return scatter(shapes, np.zeros_like(shapes), shapes >= 0, (self.coordinates * self.rows, 1))

    @cached_property
    def hessian_places(self) -> Scatters:
        """Of Hessian blocks: poses by poses (upper), poses by shapes, shapes by shapes."""
        z, g, a = (3 + self.coordinates) * self.ends, 3 * self.steps, self.coordinates * self.rows
        t, j, i = np.meshgrid(*(np.arange(k) for k in (len(self.instants), z, z)), indexing="ij")
        (pi, pj), (si, sj) = ((c[t, i], c[t, j]) for c in self.columns)
        return (
            scatter(pi, pj, (pi >= 0) & (pj >= pi), (g, g)),
            scatter(pi, sj, (pi >= 0) & (sj >= 0), (g, a)),
            scatter(si, sj, (si >= 0) & (sj >= 0), (a, a)),
        )


@dataclass(frozen=True)
class Along:
    """The gaps of all watched instants with derivatives by poses and shapes."""

    functions: GapFunctions
    watch: Watch
    steps: int
    rows: int

    @cached_property
    def _groups(self) -> list[_Group]:
        at_rows = [i for i in self.watch.instants if i[0] == 0]
        between = [i for i in self.watch.instants if i[0] > 0]
        shape = self.steps, self.rows, self.functions.coordinates
        return [
            _Group(self.functions.between if ends == 2 else self.functions.at_rows, ends, tuple(instants), *shape)
            for ends, instants in ((1, at_rows), (2, between))
            if instants
        ]

    @property
    def total(self) -> int:
        """Gaps of all instants."""
        return sum(group.total for group in self._groups)

    def value(self, cycle: Cycle) -> ca.MX:
        """All gaps, instant by instant."""
        return ca.vertcat(*(ca.vec(group.over(group.functions[0], cycle)) for group in self._groups))

    def jacobian(self, cycle: Cycle) -> tuple[ca.MX, ca.MX]:
        """Derivatives by poses and by shapes."""
        pairs = []
        for group in self._groups:
            blocks = group.over(group.functions[1], cycle)
            pairs.append([places(blocks) for places in group.jacobian_places])
        return ca.vertcat(*(pair[0] for pair in pairs)), ca.vertcat(*(pair[1] for pair in pairs))

    def hessian(self, cycle: Cycle, multipliers: ca.MX) -> tuple[ca.MX, list[tuple[Scatters, ca.MX]]]:
        """Force on the shapes (s, R); Hessian blocks and where they go, of every group of instants."""
        force, parts, ends = ca.MX(0), [], np.cumsum([0, *(group.total for group in self._groups)]).tolist()
        for group, on_group in zip(self._groups, ca.vertsplit(multipliers, ends), strict=True):
            columns = ca.reshape(on_group, group.count, len(group.instants))
            gradient, blocks = group.over(group.functions[2], cycle, columns)
            force = force + ca.densify(group.force_places(gradient))
            parts.append((group.hessian_places, blocks))
        return ca.reshape(force, self.functions.coordinates, self.rows), parts
