"""Have a shape: all joint angles at the beginning, at the end or on the way; a motion from shape to shape."""

from __future__ import annotations

from typing import Annotated, Literal

import casadi as ca
import numpy as np
from pydantic import Field

from serpenoid.errors import InputError
from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.term import Ask, Demand, Number, Played, Rows, told
from serpenoid.wording import counted


class Shape(Demand):
    """The commanded joint angles at the row nearest to `at`; of a closed gait the last shape is the first."""

    kind: Literal["shape"] = "shape"
    at: Annotated[float, Field(ge=0, le=1, description="when, as a part of the cycle or of the whole motion")] = 0.0
    angles: tuple[Number, ...] | None = Field(
        default=None, description="joint angles, tail to head [rad]; none: straight"
    )
    still: bool = Field(default=False, description="the joints rest in the step before or after, too")

    def require(self, of: Criteria) -> None:
        """One equation per joint, and with `still` another."""
        row, bends = of.row(self.at), of.bends
        of.subject_to(bends[:, row] - ca.DM(self.angles or [0.0] * bends.size1()), 0.0, 0.0)
        if self.still:
            beside = row + 1 if row + 1 < of.rows else row - 1
            of.subject_to(bends[:, beside] - bends[:, row], 0.0, 0.0)

    def outcome(self, played: Played) -> str:
        """How far the farthest joint is from its angle, and with `still` from rest."""
        bends, row = played.bends, round(self.at * played.steps) % len(played.table)
        left = np.abs(bends[row] - (0.0 if self.angles is None else np.array(self.angles))).max()
        words = told(f"shape at {self.at:g}", left, "rad")
        if not self.still:
            return words
        beside = row + 1 if row + 1 < len(bends) else row - 1
        return f"{words}; {told('rest there', np.abs(bends[beside] - bends[row]).max(), 'rad')}"

    def asks(self, rows: Rows) -> list[Ask]:
        """Every joint angle of the row."""
        if self.angles is not None and len(self.angles) != rows.joints:
            raise InputError(
                f"[[task.demands]] shape: `angles` needs {counted(rows.joints, 'number')}, got {len(self.angles)}."
            )
        row = rows.of(self.at)
        return [Ask(f"joint {j} at row {row}", v, v) for j, v in enumerate(self.angles or [0.0] * rows.joints, start=1)]
