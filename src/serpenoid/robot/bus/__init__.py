"""The servo bus: the only place that imports `dynamixel_sdk`."""

from serpenoid.robot.bus.bus import ATTEMPTS_IN_MOTION, Bus, open_bus
from serpenoid.robot.bus.collisions import REMEDY as COLLISION_REMEDY
from serpenoid.robot.bus.readings import ServoHealth, ServoState

__all__ = [
    "ATTEMPTS_IN_MOTION",
    "COLLISION_REMEDY",
    "Bus",
    "ServoHealth",
    "ServoState",
    "open_bus",
]
