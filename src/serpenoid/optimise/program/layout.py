"""What stands where among the variables of the gait NLP, and what all its parts are evaluated at.

    x = (poses g_1 .. g_T (d T), [dissipation], [servos' states], gait parameters)

Parts are derived by the poses and by q = (shapes, joint table, parameters) as far as these are not the same; Psi =
dq/dp carries q to the parameters p by the chain rule, and for free tables there is nothing to carry.

A pose has d = 3 numbers in the plane, (x, y, heading), and 6 in space, (z, pitch, roll) after them: what is asked of
the plane is asked of both.

Legend: T steps, R rows, n parameters, K path rows.
"""

from __future__ import annotations

from functools import cached_property

import casadi as ca

from serpenoid.objectives.criteria import Criteria
from serpenoid.optimise.step.blocks import Cycle
from serpenoid.optimise.step.layer import Layer
from serpenoid.optimise.step.motion_law import MotionLaw, table_layer


class Layout:
    """Symbols of the NLP of one law and criteria."""

    def __init__(self, law: MotionLaw, criteria: Criteria, path_rows: int, portable: bool) -> None:
        self.law, self.family, self.criteria, self.portable = law, law.family, criteria, portable
        self.steps, self.structure, self.path_rows = law.steps, law.structure, path_rows
        self.priced = not criteria.separable
        self.size = law.states + self.family.size
        self.moved = self.family.pose_size * self.steps
        self.start = self.moved + self.priced
        d = self.family.data.shape[1]
        self.variables = ca.MX.sym("variables", self.start + self.size)
        self.parameters = ca.MX.sym("parameters", 1 + 2 * d * path_rows + 2 * self.structure.vertices)

    @property
    def poses(self) -> ca.MX:
        """Poses (d T)."""
        return self.variables[: self.moved]

    @property
    def dissipation(self) -> ca.MX:
        """The dissipation as a variable of its own."""
        return self.variables[self.moved]

    @property
    def free(self) -> ca.MX:
        """What the shapes depend on, p: states of the servos, gait parameters."""
        return self.variables[self.start :]

    @property
    def gait(self) -> ca.MX:
        """Gait parameters (n)."""
        return self.free[self.law.states :]

    @property
    def model_parameters(self) -> ca.MX:
        """Edge lengths, weights, anisotropy ratio, shape (2 N,)."""
        return self.parameters[-2 * self.structure.vertices :]

    @property
    def at(self) -> tuple[ca.MX, ca.MX, ca.MX]:
        """What layers of the family's own rows are evaluated at."""
        return self.at_data(ca.MX(ca.DM(self.family.data.T)))

    def at_data(self, data: ca.MX) -> tuple[ca.MX, ca.MX, ca.MX]:
        """What layers of other rows are evaluated at."""
        return self.free, data, self.model_parameters

    @property
    def at_path(self) -> tuple[ca.MX, ca.MX, ca.MX]:
        """What the layer of the path rows is evaluated at; their data and those of the rows after are parameters."""
        d = 2 * self.family.data.shape[1]
        return self.at_data(ca.reshape(self.parameters[1 : 1 + d * self.path_rows], d, self.path_rows))

    @cached_property
    def cycle(self) -> Cycle:
        """What the step blocks are evaluated at."""
        size = self.family.pose_size
        poses = ca.horzcat(ca.MX.zeros(size, 1), ca.reshape(self.poses, size, self.steps))
        layer = self.law.shapes
        shapes = ca.reshape(self.gait, self.law.coordinates, -1) if layer is None else layer.value(*self.at)
        return Cycle(poses, shapes, self.family.closed, self.model_parameters, self.law.settings)

    @cached_property
    def table(self) -> Layer | None:
        """The layer of the joint table, where the criteria ask for it and the shapes are something else."""
        if not self.criteria.needs(self.criteria.angles):
            return None
        return None if self.family.free and not self.law.states else self.table_layer()

    def table_layer(self) -> Layer:
        """The layer of the joint table."""
        return self.law.behind(table_layer(self.law.family, self.structure, self.portable))

    # q = (shapes, joint table, parameters) as far as they are not the same

    @cached_property
    def groups(self) -> tuple[int, int, int]:
        """Sizes of (shapes, joint table, parameters) in q; zero where a group is left out."""
        shapes = self.law.coordinates * self.family.rows
        if self.law.shapes is None:
            return shapes, 0, 0  # all three are the same
        return shapes, 0 if self.table is None else self.criteria.angles.numel(), self.size

    @cached_property
    def psi(self) -> ca.MX | None:
        """dq/dp; None where q is p."""
        if self.law.shapes is None:
            return None
        parts = [self.law.shapes.slope(*self.at)]
        if self.table is not None:
            parts.append(self.table.slope(*self.at))
        return ca.vertcat(*parts, ca.MX.eye(self.size))

    def to_parameters(self, by_q: ca.MX) -> ca.MX:
        """A derivative by q as one by p."""
        return by_q if self.psi is None else by_q @ self.psi

    def beside(self, by_shapes: ca.MX) -> ca.MX:
        """A derivative by the shapes as one by q."""
        return ca.horzcat(by_shapes, ca.MX(by_shapes.size1(), sum(self.groups) - by_shapes.size2()))

    def square(self, by_shapes: ca.MX) -> ca.MX:
        """Second derivatives by the shapes as ones by q."""
        rest = sum(self.groups) - by_shapes.size1()
        return ca.diagcat(by_shapes, ca.MX(rest, rest)) if rest else by_shapes

    def row(self, by_poses: ca.MX, by_dissipation: ca.MX, by_q: ca.MX) -> ca.MX:
        """Rows of the Jacobian."""
        u = [by_poses, by_dissipation] if self.priced else [by_poses]
        return ca.horzcat(*u, self.to_parameters(by_q))

    def row_of_free(self, by_free: ca.MX) -> ca.MX:
        """Rows of the Jacobian of what depends on p alone."""
        return ca.horzcat(ca.MX(by_free.size1(), self.start), by_free)
