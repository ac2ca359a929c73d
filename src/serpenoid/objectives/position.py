"""To a place: the squared distance of the centroid from a target after some cycles [body lengths squared]."""

from __future__ import annotations

from typing import Literal

import casadi as ca
import numpy as np
from pydantic import Field

from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.term import Cycles, Played, Point, Term, after, told


class Position(Term):
    """|(x, y) of the body frame - target|^2 in the frame of the first row: origin centroid, x along the mean edge."""

    kind: Literal["position"] = "position"
    target: Point = Field(description="x, y [body lengths]")
    cycles: Cycles = Field(default=1, description="the cycle is played so often to get there")

    def expression(self, of: Criteria) -> ca.SX:
        """Zero where the target is reached."""
        return ca.sumsqr(of.after(self.cycles)[:2] - ca.DM(self.target))

    def outcome(self, played: Played) -> str:
        """How far from the target it ends."""
        left = np.hypot(*(after(played.poses, self.cycles)[:2] - self.target))
        return told(f"({self.target[0]:g}, {self.target[1]:g})", float(left))
