"""Swing once: a joint bends to and fro once per cycle, so that a gait is one stroke and not several in a row."""

from __future__ import annotations

from typing import Annotated, Literal

import casadi as ca
import numpy as np
from pydantic import Field

from serpenoid.errors import InputError
from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.term import Ask, Demand, Played, Rows, told


class Swing(Demand):
    """The joint's angle never falls in the first half of the cycle and never rises in the second; fixes the phase."""

    kind: Literal["swing"] = "swing"
    joint: Annotated[int, Field(ge=1, description="number of the joint, from the tail")] = 1

    def require(self, of: Criteria) -> None:
        """One inequality per step."""
        change, half = of.changes[self.joint - 1, :], of.steps // 2
        of.subject_to(ca.horzcat(change[:half], -change[half:]), 0.0, ca.inf)

    def outcome(self, played: Played) -> str:
        """By how much a step goes the other way."""
        bend, half = played.bends[:, self.joint - 1], played.steps // 2
        change = np.diff(bend, append=bend[: played.steps + 1 - len(bend)])
        wrong = np.concatenate([-change[:half], change[half:], [0.0]]).max()
        return told(f"swing of joint {self.joint}", wrong, "rad")

    def asks(self, rows: Rows) -> list[Ask]:
        """Nothing that others ask, but the joint must be there."""
        if self.joint > rows.joints:
            raise InputError(f"[[task.demands]] swing: `joint` must be at most {rows.joints}, got {self.joint}.")
        return []
