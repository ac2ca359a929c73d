"""The robot file: which servo moves which joint, how far, how fast, over which bus, from which battery."""

from __future__ import annotations

from math import tau
from typing import ClassVar, Literal, Self

from pydantic import Field, model_validator

from serpenoid.files.schema import Name, Record
from serpenoid.robot.control_table import BAUD_RATES, TICKS_PER_TURN

# Three quarters of the XL430's torque (all of it: 177 ticks, 15.6 degrees), and twice the largest error of a healthy
# robot on a floor that grips (6.3 degrees: `results/benchmarks/robustness.md`).
TRACKING_LIMIT_DEG = 12.0


class JointServo(Record):
    """One servo: `ticks = zero_ticks + sign * angle * 4096 / (2 pi)`, kept in minimum_ticks..maximum_ticks."""

    id: int = Field(ge=0, le=252)
    sign: Literal[-1, 1]
    zero_ticks: int = Field(ge=0, le=TICKS_PER_TURN - 1)
    minimum_ticks: int = Field(ge=0, le=TICKS_PER_TURN - 1)
    maximum_ticks: int = Field(ge=0, le=TICKS_PER_TURN - 1)
    speed_limit_rpm: float = Field(gt=0, le=61.0)

    @model_validator(mode="after")
    def _limits_in_order(self) -> Self:
        if not self.minimum_ticks < self.zero_ticks < self.maximum_ticks:
            raise ValueError("`minimum_ticks` < `zero_ticks` < `maximum_ticks` is required")
        return self

    @property
    def angle_range(self) -> tuple[float, float]:
        """Smallest and largest joint angle [rad]."""
        ends = [
            self.sign * (t - self.zero_ticks) * tau / TICKS_PER_TURN for t in (self.minimum_ticks, self.maximum_ticks)
        ]
        return min(ends), max(ends)


class BusSettings(Record):
    baud_rate: int = 57600
    protocol: float = Field(default=2.0, ge=2.0, le=2.0)

    @model_validator(mode="after")
    def _servo_knows_the_rate(self) -> Self:
        if self.baud_rate not in BAUD_RATES.values():
            raise ValueError(f"`baud_rate` must be one of {', '.join(map(str, BAUD_RATES.values()))}")
        return self


class MotionSettings(Record):
    cycle_duration_s: float = Field(gt=0, le=600)
    approach_speed_rpm: float = Field(default=5.0, gt=0, le=20)
    approach_limit_deg: float = Field(default=90.0, gt=0, le=360)
    watchdog_s: float = Field(default=0.5, ge=0.2, le=2.5)  # silence after which a servo stops by itself
    arrival_tolerance_deg: float | None = Field(default=None, gt=0, le=30)  # None: limit_deg of [tracking]


class TrackingRule(Record):
    """How far a joint may stand from where its commands of the last `lag_s` were, and what happens beyond."""

    limit_deg: float = Field(default=TRACKING_LIMIT_DEG, gt=0, le=180)
    lag_s: float = Field(default=0.3, ge=0.05, le=2.0)
    action: Literal["stop", "slow", "warn"] = "stop"


class VoltageWindow(Record):
    """Measured at the servos' own input."""

    minimum_V: float = Field(ge=6.0, le=14.0)
    maximum_V: float = Field(ge=6.0, le=14.0)
    nominal_V: float = Field(default=11.1, ge=6.0, le=14.0)

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if not self.minimum_V <= self.nominal_V <= self.maximum_V:
            raise ValueError("`minimum_V` <= `nominal_V` <= `maximum_V` is required")
        return self


class Robot(Record):
    """A robot file; joints in the order joint_1 (next to the tail) ... joint_m (next to the head)."""

    file_kind: ClassVar[str | None] = "robot"

    format: Literal[1]
    name: Name
    model: Literal["XL430-W250-T"] = "XL430-W250-T"
    bus: BusSettings
    motion: MotionSettings
    voltage: VoltageWindow
    tracking: TrackingRule = TrackingRule()
    joint: list[JointServo] = Field(min_length=1, max_length=60)

    @model_validator(mode="after")
    def _one_servo_per_joint(self) -> Self:
        ids = self.ids
        twice = sorted({servo_id for servo_id in ids if ids.count(servo_id) > 1})
        if twice:
            raise ValueError(f"servo ID {twice[0]} is used by two joints; every [[joint]] needs its own `id`")
        return self

    @property
    def arrival_tolerance_deg(self) -> float:
        """How far from the first row a joint may come to rest."""
        own = self.motion.arrival_tolerance_deg
        return self.tracking.limit_deg if own is None else own

    @property
    def ids(self) -> list[int]:
        return [joint.id for joint in self.joint]

    def joint_label(self, index: int) -> str:
        return f"joint_{index + 1} (ID {self.joint[index].id})"
