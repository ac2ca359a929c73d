"""What a problem file can ask of a gait: terms of the objective, and demands. One kind per file, found by listing."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

import casadi as ca
import numpy as np
from pydantic import Field

from serpenoid.body import Floats
from serpenoid.files.schema import Record
from serpenoid.objectives.criteria import Criteria


@dataclass(frozen=True)
class Played:
    """A motion from the origin: poses (T + 1, 3), vertices (T + 1, N, 2) and the joint table (R, m) that made it."""

    poses: Floats
    vertices: Floats
    table: Floats


class Goal(Record):
    """What is asked, whichever way."""

    kind: str

    def outcome(self, played: Played) -> str:
        """What a motion makes of it, in words; empty: nothing to say."""
        return ""


class Term(Goal):
    """One term of the objective, times its weight; one entry of `[[task.objectives]]`."""

    weight: float = Field(default=1.0, ge=0, description="factor of this term in the objective")

    @abstractmethod
    def expression(self, of: Criteria) -> ca.SX:
        """The term's value, to be minimised."""


class Demand(Goal):
    """One requirement; one entry of `[[task.demands]]`."""

    @abstractmethod
    def require(self, of: Criteria) -> None:
        """Add the requirement to the criteria."""


def after(poses: Floats, cycles: int) -> Floats:
    """Pose (3,) after several cycles of a motion with poses (T + 1, 3) from the origin."""
    x, y, turn = poses[-1]
    gone = (x + 1j * y) * np.exp(1j * turn * np.arange(cycles)).sum()
    return np.array([gone.real, gone.imag, cycles * turn])
