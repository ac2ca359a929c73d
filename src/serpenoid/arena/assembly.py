"""One robot on one floor, as put together: the healthy numbers spread over wheels, servos and links.

A hidden change is a function from one assembly to another; the neutral values here are the healthy robot.
Legend: 12 wheel pairs numbered like the vertices (0 tail .. 11 head), 10 servos and 11 links from the tail.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np

from serpenoid.arena.robot import SERVOS, WHEELS, Robot
from serpenoid.body import Floats


def _filled(shape: int | tuple[int, ...], value: float) -> Any:
    return field(default_factory=lambda: np.full(shape, value))


@dataclass(frozen=True)
class Patch:
    """A round place on the floor whose grip is multiplied by `factor`, with a soft rim."""

    x_m: float
    y_m: float
    radius_m: float
    factor: float


@dataclass(frozen=True)
class Pull:
    """A force on one link: constant, towards a point, or for a while only; `kind` decides (see `forces.py`)."""

    kind: str
    link: int
    values: tuple[float, ...]


@dataclass(frozen=True)
class Assembly:
    """What the scene is built from; arrays are never written to (use `with_item`)."""

    robot: Robot
    toe: Floats = _filled(WHEELS, 0.0)  # rad, counter-clockwise turn of the wheel set against its link
    lift: Floats = _filled(WHEELS, 0.0)  # m, above where it should be
    grip: Floats = _filled((WHEELS, 2), 1.0)  # factor on the friction coefficient, left and right wheel
    grip_against: Floats = _filled(2, 1.0)  # factor while slipping to the left, to the right
    bearing: Floats = _filled(WHEELS, 0.0)  # N m, additional dry torque of the bearing
    backward: Floats = _filled(WHEELS, 0.0)  # N m, additional while rolling backward
    payload: Floats = _filled(SERVOS + 1, 0.0)  # kg, at the middle of a link
    gain: Floats = _filled(SERVOS, 1.0)  # factor on the position gain
    torque: Floats = _filled(SERVOS, 1.0)  # factor on the torque limit
    scale: Floats = _filled(SERVOS, 1.0)  # factor on the commanded angle
    zero: Floats = _filled(SERVOS, 0.0)  # rad, true angle minus the servo's reading
    backlash: Floats = _filled(SERVOS, 0.0)  # rad, whole play between servo and link
    stuck: Floats = _filled(SERVOS, np.nan)  # rad, angle at which the servo is blocked
    marker: Floats = _filled((WHEELS, 2), 0.0)  # m, marker off its place, along and across its link
    voltage_V: float = 11.1  # battery under no load at the start of a trial
    voltage_drop: float = 0.0  # V per second
    slope_rad: float = 0.0
    downhill_rad: float = 0.0  # direction of the pull, on the floor
    patches: tuple[Patch, ...] = ()
    pulls: tuple[Pull, ...] = ()

    @classmethod
    def healthy(cls, robot: Robot) -> Self:
        return cls(robot, voltage_V=robot.voltage_V)

    def with_item(self, name: str, index: int | Sequence[int] | slice, value: Any) -> Self:
        """A copy in which one element (or slice) of the array `name` is `value`."""
        array = getattr(self, name).copy()
        array[index] = value
        return replace(self, **{name: array})
