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

NOTHING = 1e-7  # body lengths or radians: KKT conditions hold to 1e-8, with factors of a few in a demand's own units


@dataclass(frozen=True)
class Played:
    """A motion from the origin: poses (T + 1, 3), vertices (T + 1, N, 2) and the joint table (R, m) that made it."""

    poses: Floats
    vertices: Floats
    table: Floats


@dataclass(frozen=True)
class Ask:
    """A number of the motion that a demand confines, whatever the gait: lower <= quantity <= upper."""

    quantity: str
    lower: float
    upper: float


@dataclass(frozen=True)
class Rows:
    """What demands count by: T steps, m joints, and whether the row after the last is the first again."""

    steps: int
    joints: int
    closed: bool

    def of(self, share: float) -> int:
        """The row of joint angles nearest to a part of the cycle."""
        return round(share * self.steps) % (self.steps + (not self.closed))


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

    def asks(self, rows: Rows) -> list[Ask]:
        """What it confines by itself: demands whose intervals do not meet contradict each other."""
        return []


def miss(amount: float, digits: int = 4) -> str:
    """An amount by which something is missed: zero where it is less than the optimiser leaves of a constraint."""
    return "0" if abs(amount) < NOTHING else f"{amount:.{digits}f}" if abs(amount) >= 10**-digits else f"{amount:.0e}"


def after(poses: Floats, cycles: int) -> Floats:
    """Pose (3,) after several cycles of a motion with poses (T + 1, 3) from the origin."""
    x, y, turn = poses[-1]
    gone = (x + 1j * y) * np.exp(1j * turn * np.arange(cycles)).sum()
    return np.array([gone.real, gone.imag, cycles * turn])
