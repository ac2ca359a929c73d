"""Be somewhere: the centroid within a radius of a target, at the end or on the way (a checkpoint)."""

from __future__ import annotations

from typing import Annotated, Literal

import casadi as ca
import numpy as np
from pydantic import Field

from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.term import (
    FAR,
    NOTHING,
    Ask,
    Cycles,
    Demand,
    Number,
    Played,
    Point,
    Rows,
    after,
    beside,
    told,
)
from serpenoid.wording import counted

POINT = 1e-6  # body lengths: a disc in which optima cost the same, and whose rim is too curved to converge on


class Reach(Demand):
    """|(x, y) - target| <= radius at the row nearest to `at`; a radius of 0 to POINT asks for the target itself."""

    kind: Literal["reach"] = "reach"
    target: Point = Field(description="x, y [body lengths], in the frame of the first row")
    radius: Annotated[float, Field(ge=0, le=FAR)] = 0.0
    at: Annotated[float, Field(gt=0, le=1, description="when, as a part of the cycle")] = 1.0
    cycles: Cycles = Field(default=1, description="of `at = 1`: after so many cycles")
    heading_rad: Number | None = Field(default=None, description="heading there; default: any")

    def require(self, of: Criteria) -> None:
        """Two equations or one inequality, and the heading."""
        pose = of.after(self.cycles) if self.at == 1 else of.poses[:, self._row(of.steps)]
        gap = pose[:2] - ca.DM(self.target)
        if self.radius > POINT:
            of.subject_to(ca.sumsqr(gap), -ca.inf, self.radius**2)
        else:
            of.subject_to(gap, 0.0, 0.0)
        if self.heading_rad is not None:
            of.count_turns()
            of.subject_to(pose[2] - self.heading_rad, 0.0, 0.0)

    def outcome(self, played: Played) -> str:
        """Whether the target is met, and how far away it is then, beside the radius that is allowed."""
        poses = played.poses
        pose = after(poses, self.cycles) if self.at == 1 else poses[self._row(len(poses) - 1)]
        left = np.hypot(*(pose[:2] - self.target))
        place = f"({self.target[0]:g}, {self.target[1]:g})"
        turn = "" if self.heading_rad is None else f"; {told('heading there', pose[2] - self.heading_rad, 'rad')}"
        if self.radius == 0:
            return told(place, float(left)) + turn
        away, allowed = beside(float(left), self.radius)
        met = "met" if left < self.radius + NOTHING else "missed"
        return f"{place} {met}: {away} body lengths away, {allowed} allowed{turn}"

    def asks(self, rows: Rows) -> list[Ask]:
        """x and y within the radius; at the end of one cycle the displacement."""
        end = self.at == 1
        when = f"after {counted(self.cycles, 'cycle')}" if end else f"at step {self._row(rows.steps)}"
        found = [
            Ask(f"{axis} {when}", v - self.radius, v + self.radius) for axis, v in zip("xy", self.target, strict=True)
        ]
        if self.heading_rad is not None:
            found.append(Ask(f"heading {when}", self.heading_rad, self.heading_rad))
        if end and self.cycles == 1:
            way = float(np.hypot(*self.target))
            found.append(Ask("displacement", max(way - self.radius, 0.0), way + self.radius))
        return found

    def _row(self, steps: int) -> int:
        """Where it is asked for, if on the way."""
        return max(1, round(self.at * steps))
