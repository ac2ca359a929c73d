"""The robot file: which servo moves which joint, how far, how fast, over which bus, from which battery."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field, ValidationInfo, field_validator, model_validator

from serpenoid.body import LONGEST_CYCLE_S
from serpenoid.files.schema import Name, Record
from serpenoid.robot.models import DEFAULT, ServoModel, models
from serpenoid.robot.stated import SHORTEST_CYCLE_S
from serpenoid.wording import closest, counted


def known_model(name: str) -> str:
    """The name; raises ValueError with all names that there are, and the likeliest."""
    if name not in models():
        close = closest(name, models())
        meant = "" if close is None else f"; did you mean `{close}`?"
        raise ValueError(f"must be one of {', '.join(models())}{meant}")
    return name


ModelName = Annotated[str, AfterValidator(known_model), Field(json_schema_extra={"enum": list(models())})]


class JointServo(Record):
    """One servo: `ticks = zero_ticks + sign * gear_ratio * angle * 4096 / (2 pi)`, from minimum_ticks to maximum_ticks.

    Ticks and volts are the servo's; angles, speeds and what follows are of the joint that it turns.
    """

    model: ModelName | None = None  # None: the robot's, which `Robot` writes here
    id: int = Field(ge=0, le=252)
    sign: Literal[-1, 1]
    zero_ticks: int = Field(ge=0)
    minimum_ticks: int = Field(ge=0)
    maximum_ticks: int = Field(ge=0)
    gear_ratio: float = Field(default=1.0, ge=0.1, le=100)  # turns of the servo for one of the joint; 1: none outside
    speed_limit_rpm: float = Field(ge=0.001)

    @field_validator("zero_ticks", "minimum_ticks", "maximum_ticks")
    @classmethod
    def _in_a_turn(cls, ticks: int, info: ValidationInfo) -> int:
        servo = models().get(info.data.get("model") or "")
        if servo is not None and ticks > servo.last_tick:
            raise ValueError(f"must be at most {servo.last_tick}, the last tick of {servo.name} servos")
        return ticks

    @field_validator("speed_limit_rpm")
    @classmethod
    def _not_faster_than_its_motor(cls, rpm: float, info: ValidationInfo) -> float:
        servo, gear = models().get(info.data.get("model") or ""), info.data.get("gear_ratio", 1.0)
        if servo is not None and rpm * gear > servo.fastest[1]:
            volts, most = servo.fastest
            behind = "" if gear == 1 else f" behind a gear of {gear:g}"
            does = f"what {servo.name} servos do at {volts:g} V without load{behind}"
            raise ValueError(f"must be at most {most / gear:g} rpm, {does}")
        return rpm

    @model_validator(mode="after")
    def _limits_in_order(self) -> Self:
        if not self.minimum_ticks < self.zero_ticks < self.maximum_ticks:
            raise ValueError("`minimum_ticks` < `zero_ticks` < `maximum_ticks` is required")
        return self

    @property
    def servo(self) -> ServoModel:
        """What its model can do."""
        return models()[self.model or DEFAULT]

    @property
    def angle_range(self) -> tuple[float, float]:
        """Smallest and largest joint angle [rad]."""
        ends = [
            self.sign * (t - self.zero_ticks) * self.radians_per_tick for t in (self.minimum_ticks, self.maximum_ticks)
        ]
        return min(ends), max(ends)

    @property
    def radians_per_tick(self) -> float:
        """What a tick of the servo turns the joint by [rad]."""
        return self.servo.radians_per_tick / self.gear_ratio

    @property
    def ticks_per_turn(self) -> float:
        """Ticks of the servo for a turn of the joint."""
        return self.servo.ticks_per_turn * self.gear_ratio

    @property
    def rpm_per_velocity_unit(self) -> float:
        """What a unit of the servo's speed registers turns the joint by [rpm]."""
        return self.servo.rpm_per_velocity_unit / self.gear_ratio

    @property
    def tracking_limit_deg(self) -> float:
        """How far the joint may stand from its command, as its servo's gain has it [degrees]."""
        return self.servo.tracking_limit_deg / self.gear_ratio

    def velocity_units(self, rpm: float) -> int:
        """A speed of the joint in the servo's registers."""
        return self.servo.velocity_units(rpm * self.gear_ratio)

    def no_load_speed_rpm(self, voltage: float) -> float:
        """Of the joint, without load."""
        return self.servo.no_load_speed_rpm(voltage) / self.gear_ratio


class BusSettings(Record):
    baud_rate: int = 57600
    protocol: float = Field(default=2.0, ge=2.0, le=2.0)


class MotionSettings(Record):
    cycle_duration_s: float = Field(ge=SHORTEST_CYCLE_S, le=LONGEST_CYCLE_S)
    approach_speed_rpm: float = Field(default=5.0, gt=0, le=20)
    approach_limit_deg: float = Field(default=90.0, gt=0, le=360)
    watchdog_s: float = Field(default=0.5, ge=0.2, le=2.5)  # silence after which a servo stops by itself
    arrival_tolerance_deg: float | None = Field(default=None, gt=0, le=30)  # None: as in [tracking]


class TrackingRule(Record):
    """How far a joint may stand from where its commands of the last `lag_s` were, and what happens beyond."""

    limit_deg: float | None = Field(default=None, gt=0, le=180)  # None: of each servo's model
    lag_s: float = Field(default=0.3, ge=0.05, le=2.0)
    action: Literal["stop", "slow", "warn"] = "stop"


class VoltageWindow(Record):
    """Measured at the servos' own input."""

    minimum_V: float = Field(gt=0)
    maximum_V: float = Field(gt=0)
    nominal_V: float | None = Field(default=None, gt=0)  # None: what the servos are recommended for

    @property
    def told(self) -> dict[str, float]:
        """Voltages by the keys that the file gives them."""
        return {key: volts for key, volts in self.model_dump().items() if volts is not None}


class Robot(Record):
    """A robot file; joints in the order joint_1 (next to the tail) ... joint_m (next to the head)."""

    file_kind: ClassVar[str | None] = "robot"

    format: Literal[1]
    name: Name
    model: ModelName = DEFAULT  # of every joint that names no other
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

    @model_validator(mode="before")
    @classmethod
    def _joints_have_the_robots_model(cls, data: Any) -> Any:
        """A joint that names no model has the robot's: so each can be judged by what its own servo can."""
        joints, model = (data.get("joint"), data.get("model", DEFAULT)) if isinstance(data, dict) else (None, None)
        if not isinstance(joints, list | tuple) or not isinstance(model, str) or model not in models():
            return data
        named = [j | {"model": model} if isinstance(j, dict) and j.get("model") is None else j for j in joints]
        return data | {"joint": named}

    @model_validator(mode="after")
    def _its_servos_can_do_that(self) -> Self:
        weak = min(self.kinds, key=lambda servo: servo.voltage_range[1])
        strong = max(self.kinds, key=lambda servo: servo.voltage_range[0])
        if weak.voltage_range[1] < strong.voltage_range[0]:
            told = " and ".join("{} servos ({:g} to {:g} V)".format(s.name, *s.voltage_range) for s in (weak, strong))
            raise ValueError(f"{told} share no voltage, so no one supply suits both: take other models")
        for fault in (fault for servo in self.kinds for fault in self._beyond(servo)):
            raise ValueError(fault)
        if not self.voltage.minimum_V <= self.nominal_V <= self.voltage.maximum_V:
            said = "" if self.voltage.nominal_V is not None else f"; without a word `nominal_V` is {self.nominal_V:g}"
            raise ValueError(f"`minimum_V` <= `nominal_V` <= `maximum_V` is required in [voltage]{said}")
        for one, other in pairwise(self.kinds):
            if one.shared != other.shared:
                raise ValueError(
                    f"{one.name} and {other.name} servos keep goal, torque or state elsewhere; use one of them"
                )
        return self

    def _beyond(self, servo: ServoModel) -> Iterator[str]:
        """What this file asks of one model that it cannot do."""
        rates, (low, high) = servo.baud_rates.values(), servo.voltage_range
        if self.bus.baud_rate not in rates:
            had = f"`baud_rate` must be one of {', '.join(map(str, rates))}"
            yield f"{had} for {servo.name} servos, got {self.bus.baud_rate}"
        for key, volts in self.voltage.told.items():
            if not low <= volts <= high:
                yield f"{servo.name} servos need {low:g} to {high:g} V; `{key}` is {volts:g}"

    @property
    def servos(self) -> list[ServoModel]:
        """Each joint's model."""
        return [joint.servo for joint in self.joint]

    @property
    def kinds(self) -> list[ServoModel]:
        """Every model that there is in the chain, once, tail first."""
        return list(dict.fromkeys(self.servos))

    @property
    def by_id(self) -> dict[int, ServoModel]:
        """Each servo's model."""
        return {joint.id: joint.servo for joint in self.joint}

    @property
    def nominal_V(self) -> float:  # noqa: N802 (the file's key)
        """The voltage at which a gait is judged where none is measured."""
        told = self.voltage.nominal_V
        return models()[self.model].recommended_V if told is None else told

    @property
    def tracking_limits_deg(self) -> NDArray[np.float64]:
        """How far each joint may stand from its command (m,)."""
        told = self.tracking.limit_deg
        return np.array([joint.tracking_limit_deg if told is None else told for joint in self.joint])

    @property
    def arrival_tolerances_deg(self) -> NDArray[np.float64]:
        """How far from the first row each joint may come to rest (m,)."""
        own = self.motion.arrival_tolerance_deg
        return self.tracking_limits_deg if own is None else np.full(len(self.joint), own)

    def in_words(self) -> str:
        """`10 servos XL430-W250-T`; of several models `6 servos XM430-W350 and 4 servos XL430-W250-T`."""
        return " and ".join(f"{counted(self.servos.count(kind), 'servo')} {kind.name}" for kind in self.kinds)

    @property
    def ids(self) -> list[int]:
        return [joint.id for joint in self.joint]

    def joint_label(self, index: int) -> str:
        return f"joint_{index + 1} (ID {self.joint[index].id})"
