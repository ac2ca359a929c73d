"""One step of the gait NLP with exact first and second derivatives: what all kinds of shape coordinates offer.

    outer variables of step t:  g_t (d), g_{t+1} (d), a_t (s), a_{t+1} (s)        o = 2 d + 2 s

Three kinds: coordinates (w1, w2, xi) of a serpenoid (`serpenoid_blocks`, cheap for any number of joints), joint angles
(`joint_blocks`, with or without effects), and both waves of a lifted body in space (`lifted_blocks`). Each maps its
compiled step over the cycle. Legend: T steps, R rows, d numbers of a pose, v values per step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import casadi as ca

from serpenoid.mechanics.wide import Columns


@dataclass(frozen=True)
class Cycle:
    """What the blocks are evaluated at: poses (d, T + 1), shape coordinates (s, R), settings of the steps, parameters.

    `closed`: the row after the last is the first. settings (6, T) are for models with effects only.
    """

    poses: ca.MX
    shapes: ca.MX
    closed: bool
    parameters: ca.MX
    settings: ca.MX | None = None

    @property
    def steps(self) -> int:
        """T."""
        return int(self.poses.size2()) - 1

    @property
    def ends(self) -> tuple[ca.MX, ca.MX]:
        """Shapes before and after each step."""
        rows = self.shapes
        following = ca.horzcat(rows[:, 1:], rows[:, 0]) if self.closed else rows[:, 1:]
        return (rows if self.closed else rows[:, : self.steps]), following

    def over(self, function: Columns, *more: ca.MX) -> ca.MX | tuple[ca.MX, ...]:
        """A function of (pose, pose after, shape, shape after, more .., parameters) of every step."""
        poses = self.poses[:, :-1], self.poses[:, 1:]
        return function(self.steps, *poses, *self.ends, *more, self.parameters)


class StepBlocks(Protocol):
    """Values and derivatives of all steps of a cycle.

    values: v, residuals (and what else the model's equations combine) per step.
    """

    values: int

    def value(self, cycle: Cycle) -> tuple[ca.MX, ca.MX]:
        """Values (v, T) and energies (1, T)."""

    def jacobian(self, cycle: Cycle) -> ca.MX:
        """d values, shape (v, o T)."""

    def gradient(self, cycle: Cycle) -> ca.MX:
        """d energy, shape (1, o T)."""

    def hessian(self, cycle: Cycle, multipliers: ca.MX, factors: ca.MX) -> tuple[ca.MX, ca.MX]:
        """Gradient (o, T) and Hessian (o, o T) of multipliers (v, T) . values + factors (1, T) energy."""
