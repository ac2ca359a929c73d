"""What the criteria ask of the gait NLP, derived by its variables: objective, their own constraints, their Hessian.

Criteria are Functions of z = (poses, dissipation, joint table, gait parameters); here their derivatives by z become
those by the NLP's (poses, dissipation, q), see `layout`.
"""

from __future__ import annotations

from functools import cached_property

import casadi as ca
import numpy as np

from serpenoid.optimise.program.layout import Layout


class CriteriaRows:
    """Criteria at the layout's variables; `dissipation`: T times the steps' energies; penalised: whether it counts."""

    def __init__(self, layout: Layout, dissipation: ca.MX, penalised: bool) -> None:
        self.layout, self.criteria, self.dissipation = layout, layout.criteria, dissipation
        self.needs_energy = layout.priced or (penalised and self.criteria.needs(self.criteria.dissipation))

    @cached_property
    def value(self) -> tuple[ca.MX, ca.MX]:
        """Objective and constraints."""
        f, g = self.criteria.function(*self._at)
        gaps = [apart.value(self._table) for apart in self.criteria.apart]
        return ca.densify(f), ca.vertcat(g, *gaps)  # nothing but demands is asked for: no entry

    @property
    def count(self) -> int:
        """Number of the criteria's constraints."""
        return self.criteria.count

    def derived(self, factor: ca.MX | float, multipliers: ca.MX) -> tuple[ca.MX, ca.MX, ca.MX]:
        """Gradient of the objective, Jacobian of the constraints, Hessian of the Lagrangian by z."""
        apart = self.criteria.apart
        ends = np.cumsum([0, self.count - sum(a.count for a in apart), *(a.count for a in apart)]).tolist()
        own, *on_apart = ca.vertsplit(multipliers, ends)
        gradient, jacobian, hessian = self._derived(*self._at, factor, own)
        before, after = self.layout.moved + 1, self.criteria.gait.numel()
        for gaps, on_gaps in zip(apart, on_apart, strict=True):
            slope = ca.horzcat(ca.MX(gaps.count, before), gaps.jacobian(self._table), ca.MX(gaps.count, after))
            jacobian = ca.vertcat(jacobian, slope)
            curvature = gaps.hessian(self._table, on_gaps)
            hessian = hessian + ca.diagcat(ca.MX(before, before), curvature, ca.MX(after, after))
        return ca.densify(gradient), jacobian, hessian

    def slope(self) -> tuple[ca.MX, ca.MX, ca.MX]:
        """Derivatives of the objective by poses, dissipation and q, rows."""
        return self._columns(self.derived(1, ca.MX.zeros(self.count))[0].T)

    def jacobian(self) -> tuple[ca.MX, ca.MX, ca.MX]:
        """Derivatives of the constraints by poses, dissipation and q."""
        return self._columns(self.derived(0, ca.MX.zeros(self.count))[1])

    def of_energy(self, gradient: ca.MX) -> ca.MX:
        """What the dissipation weighs in the objective, where it is no variable."""
        return gradient[self.layout.moved] if self.needs_energy else ca.MX(0)

    def curvature(self, hessian: ca.MX) -> tuple[ca.MX, ca.MX, ca.MX]:
        """The Lagrangian's (u by u, u by q, q by q), u = (poses, [dissipation])."""
        poses, dissipation, by_q = self._columns(hessian)
        left = ca.horzcat(poses, dissipation) if self.layout.priced else poses
        start = self.layout.start
        return left[:start, :], by_q[:start, :], self._columns(by_q.T)[2]

    def on_table(self, by_z: ca.MX) -> ca.MX:
        """The joint table's part (m, R) of a gradient by z."""
        start = self.layout.moved + 1
        return ca.reshape(by_z[start : start + self.criteria.angles.numel()], self.criteria.joints, -1)

    @cached_property
    def _at(self) -> list[ca.MX]:
        """Arguments of the criteria's functions."""
        c, layout = self.criteria, self.layout
        if layout.table is not None:
            angles = ca.vec(layout.table.value(*layout.at))
        else:
            angles = layout.gait if c.needs(c.angles) else ca.MX.zeros(c.angles.numel())
        own = layout.dissipation if layout.priced else self.dissipation if self.needs_energy else ca.MX(0)
        return [layout.poses, angles, own, layout.gait, layout.parameters[0]]

    @property
    def _table(self) -> ca.MX:
        """The joint table (m R) as one column."""
        return self._at[1]

    @cached_property
    def _derived(self) -> ca.Function:
        """Criteria's inputs, factor, multipliers -> gradient, Jacobian, Hessian by z."""
        c = self.criteria
        factor, multipliers = ca.SX.sym("factor"), ca.SX.sym("multipliers", c.constraints.numel())
        z = ca.vertcat(c.moved, c.dissipation, c.angles, c.gait)
        lagrangian = factor * c.objective + ca.dot(multipliers, c.constraints)
        outputs = [ca.gradient(c.objective, z), ca.jacobian(c.constraints, z), ca.hessian(lagrangian, z)[0]]
        return ca.Function("criteria_derivatives", [*c.inputs, factor, multipliers], outputs)

    def _columns(self, matrix: ca.MX) -> tuple[ca.MX, ca.MX, ca.MX]:
        """A derivative by z split into those by poses, dissipation and q (shapes first: none)."""
        layout, n, m = self.layout, self.layout.moved, self.criteria.angles.numel()
        poses, dissipation, angles, gait = ca.horzsplit(matrix, [0, n, n + 1, n + 1 + m, matrix.size2()])
        none, law = ca.MX(matrix.size1(), layout.groups[0]), layout.law
        if law.shapes is None:
            return poses, dissipation, (angles if m and layout.family.free else 0) + gait
        if law.states:
            gait = ca.horzcat(ca.MX(matrix.size1(), law.states), gait)
        elif layout.family.free:
            return poses, dissipation, ca.horzcat(none, angles + gait)
        middle = [] if layout.table is None else [angles]
        return poses, dissipation, ca.horzcat(none, *middle, gait)
