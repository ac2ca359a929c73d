"""To a heading: the squared distance of the heading from a target after some cycles [rad^2]; turns are counted."""

from __future__ import annotations

from typing import Literal

import casadi as ca
from pydantic import Field

from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.term import Cycles, Number, Played, Term, told


class Heading(Term):
    """(heading - target)^2, the heading of the first row being zero."""

    kind: Literal["heading"] = "heading"
    target_rad: Number = Field(description="counter-clockwise [rad]; beyond pi: more than half a turn")
    cycles: Cycles = Field(default=1, description="the cycle is played so often")

    def expression(self, of: Criteria) -> ca.SX:
        """Zero where the heading is met."""
        of.count_turns()
        return (self.cycles * of.heading_change - self.target_rad) ** 2

    def outcome(self, played: Played) -> str:
        """How far from the heading it ends."""
        left = self.cycles * float(played.poses[-1, 2]) - self.target_rad
        return told(f"heading {self.target_rad:g} rad", left, "rad")
