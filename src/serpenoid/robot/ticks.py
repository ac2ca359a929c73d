"""Radians to servo ticks and back: `ticks = zero_ticks + sign * round(angle / tick)`, tick = 2 pi / ticks per turn of
the joint, between which and the servo a gear may stand.

m: joints. The round trip radians -> ticks -> radians is exact within half a tick, pi / 4096 rad of most servos.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from serpenoid.robot.description import Robot
from serpenoid.robot.models import models


def coarsest_tick() -> float:
    """Of any model [rad]: by less no servo tells two angles apart for sure."""
    return max(servo.radians_per_tick for servo in models().values())


def radians_per_tick(robot: Robot) -> NDArray[np.float64]:
    """Of each joint (m,)."""
    return np.array([joint.radians_per_tick for joint in robot.joint])


def to_ticks(angles: ArrayLike, robot: Robot) -> NDArray[np.int64]:
    """Joint angles (..., m) [rad] to servo positions (..., m) [ticks]; angles must be finite."""
    turned = np.rint(np.asarray(angles, dtype=float) / radians_per_tick(robot))
    return _zeros(robot) + _signs(robot) * turned.astype(np.int64)


def to_radians(ticks: ArrayLike, robot: Robot) -> NDArray[np.float64]:
    """Servo positions (..., m) [ticks] to joint angles (..., m) [rad]."""
    turned = (np.asarray(ticks, dtype=np.int64) - _zeros(robot)) * _signs(robot)
    return np.asarray(turned * radians_per_tick(robot), dtype=np.float64)


def _zeros(robot: Robot) -> NDArray[np.int64]:
    return np.array([joint.zero_ticks for joint in robot.joint])


def _signs(robot: Robot) -> NDArray[np.int64]:
    return np.array([joint.sign for joint in robot.joint])
