"""A servo's motion in position mode: a velocity profile towards the goal, followed with a lag.

profile: |v| <= Profile Velocity (0: as fast as the motor can), |dv/dt| <= Profile Acceleration (0: at once)
position: first-order lag behind the profile, never faster than the no-load speed at the present voltage
"""

from __future__ import annotations

from math import copysign, exp, inf, sqrt

from serpenoid.robot.models import ServoModel

STEP_S = 0.002
LAG_S = 0.020


class Motion:
    """Position, profile and speed of one shaft [ticks, s]."""

    def __init__(self, position: float, model: ServoModel) -> None:
        self._model = model
        self.per_rpm = model.ticks_per_turn / 60.0  # [ticks/s]
        self.per_unit = model.rpm_per_velocity_unit * self.per_rpm  # [ticks/s]
        self._per_acceleration_unit = model.rpm2_per_acceleration_unit * model.ticks_per_turn / 3600.0  # [ticks/s^2]
        self.position = position
        self.profile = position
        self.velocity = 0.0
        self.fastest_rpm = inf  # what is in its way allows no more
        self._profile_velocity = 0.0

    def rest(self) -> None:
        """Motor off, or held where it is: the profile starts again from here."""
        self.profile = self.position
        self.velocity = self._profile_velocity = 0.0

    def advance(self, duration: float, goal: float, velocity: int, acceleration: int, voltage: float) -> None:
        """Move for `duration` [s] towards `goal` with the register values of the profile."""
        fastest = min(self._model.no_load_speed_rpm(voltage), self.fastest_rpm) * self.per_rpm
        remaining = duration
        while remaining > 0:
            step = min(STEP_S, remaining)
            self.walk_profile(step, goal, velocity, acceleration, voltage)
            pull = (self.profile - self.position) * (1 - exp(-step / LAG_S))
            moved = copysign(min(abs(pull), fastest * step), pull)
            self.position += moved
            self.velocity = moved / step
            remaining -= step

    def walk_profile(self, duration: float, goal: float, velocity: int, acceleration: int, voltage: float) -> None:
        """Move the profile alone; it never asks for more than the no-load speed."""
        fastest = self._model.no_load_speed_rpm(voltage) * self.per_rpm
        limit = min(velocity * self.per_unit, fastest) if velocity else fastest
        self._move_profile(duration, goal, limit, acceleration * self._per_acceleration_unit)

    def _move_profile(self, step: float, goal: float, limit: float, acceleration: float) -> None:
        distance = goal - self.profile
        wanted = copysign(min(limit, sqrt(2 * acceleration * abs(distance)) if acceleration else limit), distance)
        if acceleration:
            change = wanted - self._profile_velocity
            wanted = self._profile_velocity + copysign(min(abs(change), acceleration * step), change)
        travel = wanted * step
        if abs(travel) >= abs(distance) and travel * distance >= 0:
            self.profile, self._profile_velocity = goal, 0.0
        else:
            self.profile += travel
            self._profile_velocity = wanted
