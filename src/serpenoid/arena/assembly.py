"""One robot on one floor, as put together: the healthy numbers spread over wheels, servos and links.

A hidden change is a function from one assembly to another; the neutral values here are the healthy robot.
Legend: N wheel pairs numbered like the vertices (0 tail .. N - 1 head), m servos and m + 1 links from the tail.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from serpenoid.arena.robot import Robot
from serpenoid.body import Floats


@dataclass(frozen=True)
class Patch:
    """A round place on the floor whose grip is multiplied by `factor`, with a soft rim."""

    x_m: float
    y_m: float
    radius_m: float
    factor: float


@dataclass(frozen=True)
class Pull:
    """A force on one link: constant, towards a point, or for a while only; `kind` decides."""

    kind: str
    link: int
    values: tuple[float, ...]


@dataclass(frozen=True)
class Assembly:
    """What the scene is built from; arrays are never written to (use `with_item`)."""

    robot: Robot
    toe: Floats  # rad, counter-clockwise turn of the wheel set against its link
    lift: Floats  # m, above where it should be
    grip: Floats  # factor on the friction coefficient, left and right wheel
    grip_against: Floats  # factor while slipping to the left, to the right
    bearing: Floats  # N m, additional dry torque of the bearing
    backward: Floats  # N m, additional while rolling backward
    payload: Floats  # kg, at the middle of a link
    gain: Floats  # factor on the position gain
    torque: Floats  # factor on the torque limit
    scale: Floats  # factor on the commanded angle
    zero: Floats  # rad, true angle minus the servo's reading
    backlash: Floats  # rad, whole play between servo and link
    stuck: Floats  # rad, angle at which the servo is blocked
    marker: Floats  # m, marker off its place, along and across its link
    voltage_V: float = 11.1  # battery under no load at the start of a trial
    voltage_drop: float = 0.0  # V per second
    slope_rad: float = 0.0
    downhill_rad: float = 0.0  # direction of the pull, on the floor
    patches: tuple[Patch, ...] = ()
    pulls: tuple[Pull, ...] = ()

    @classmethod
    def healthy(cls, robot: Robot) -> Self:
        n, m = robot.wheels, robot.servos
        return cls(
            robot=robot,
            toe=np.zeros(n),
            lift=np.zeros(n),
            grip=np.ones((n, 2)),
            grip_against=np.ones(2),
            bearing=np.zeros(n),
            backward=np.zeros(n),
            payload=np.zeros(m + 1),
            gain=np.ones(m),
            torque=np.ones(m),
            scale=np.ones(m),
            zero=np.zeros(m),
            backlash=np.zeros(m),
            stuck=np.full(m, np.nan),
            marker=np.zeros((n, 2)),
            voltage_V=robot.voltage_V,
        )

    def with_item(self, name: str, index: int | Sequence[int] | slice, value: Any) -> Self:
        """A copy in which one element (or slice) of the array `name` is `value`."""
        array = getattr(self, name).copy()
        array[index] = value
        return replace(self, **{name: array})
