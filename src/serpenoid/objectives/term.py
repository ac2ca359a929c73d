"""What a problem file can ask of a gait: terms of the objective, and demands. One kind per file, found by listing."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Annotated, ClassVar

import casadi as ca
import numpy as np
from pydantic import Field

from serpenoid.body import Floats
from serpenoid.files.schema import Record
from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.frames import composed

FAR = 1e6  # body lengths, radians: rounding of larger numbers is no less than what the optimiser leaves of a constraint
MOST_CYCLES = 1000  # that a goal counts: each is an expression of its own
Number = Annotated[float, Field(ge=-FAR, le=FAR)]
Point = tuple[Number, Number]
Cycles = Annotated[int, Field(ge=1, le=MOST_CYCLES)]
NOTHING = 1e-7  # body lengths or radians: KKT conditions hold to 1e-8, with factors of a few in a demand's own units


@dataclass(frozen=True)
class Played:
    """A cycle's motion from the origin: poses (T + 1, 3), vertices (T + 1, N, 2), the joint table (R, m) that made it.

    In space poses have six numbers, see `frames`, vertices three, and the table pitches after the yaws.
    """

    poses: Floats
    vertices: Floats
    table: Floats

    @property
    def steps(self) -> int:
        """T."""
        return len(self.poses) - 1

    @property
    def bends(self) -> Floats:
        """Joint angles (R, m) in the body's own plane."""
        return self.table if self.poses.shape[1] == 3 else self.table[:, : self.table.shape[1] // 2]


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
    flat: ClassVar[str] = ""  # why it cannot be asked in space; empty: it can

    def outcome(self, played: Played) -> str:
        """What a motion makes of it, in words; empty: nothing to say."""
        return ""


class Term(Goal):
    """One term of the objective, times its weight; one entry of `[[task.objectives]]`."""

    weight: float = Field(default=1.0, ge=0, le=1e6, description="factor of this term in the objective")

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


def told(what: str, off: float, unit: str = "body lengths") -> str:
    """`what` is met, or by how much it is missed."""
    return f"{what} met" if abs(off) < NOTHING else f"{what} missed by {miss(off)} {unit}"


def beside(amount: float, allowed: float) -> tuple[str, str]:
    """An amount and what is allowed of it: alike where they differ by less than the optimiser leaves of a constraint,
    else with as many digits as tell them apart."""
    if abs(amount - allowed) < NOTHING:
        return f"{allowed:g}", f"{allowed:g}"
    digits = next(d for d in range(4, 10) if f"{amount:.{d}f}" != f"{allowed:.{d}f}")
    few = allowed < 10**-digits or round(allowed, digits) == allowed
    return miss(amount, digits), f"{allowed:g}" if few else f"{allowed:.{digits}f}"


def after(poses: Floats, cycles: int) -> Floats:
    """Pose (3 or 6,) after several cycles of a motion with poses (T + 1, 3 or 6) from the origin."""
    motion, pose = ca.DM(poses[-1]), ca.DM.zeros(poses.shape[1])
    for _ in range(cycles):
        pose = composed(pose, motion)
    return np.asarray(pose.full()[:, 0])


def places(poses: Floats) -> Floats:
    """Where the frames of poses (R, 3 or 6) are, shape (R, 2 or 3)."""
    return poses[:, :2] if poses.shape[1] == 3 else poses[:, [0, 1, 3]]
