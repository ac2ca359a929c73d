"""The arena under the emulated servo bus: `play` talks to emulated servos, and they move the arena's robot.

The emulator keeps control tables, profiles, watchdogs and protection; shafts are turned by the arena's motors against
the arena's floor. Time is the emulator's: the robot moves in pieces of one camera frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from serpenoid.arena.bench import CENTRE, Bench
from serpenoid.body import Floats
from serpenoid.files import write_csv
from serpenoid.robot.description import JointServo
from serpenoid.robot.emulator.motion import Motion
from serpenoid.robot.emulator.servo import EmulatedServo

FRAME_S = 1 / 120
LONGEST_S = 1.0  # a pause of the emulator longer than this is not caught up with


class Shaft(Motion):
    """A shaft that the arena turns: only its profile is walked here."""

    def advance(self, duration: float, goal: float, velocity: int, acceleration: int, voltage: float) -> None:
        self.walk_profile(duration, goal, velocity, acceleration, voltage)

    def rest(self) -> None:
        self.profile = self.position
        self._profile_velocity = 0.0


class Ground:
    """The robot that the emulated servos are built into, filmed by ideal cameras."""

    def __init__(self, bench: Bench, servos: Sequence[EmulatedServo], joints: Sequence[JointServo]) -> None:
        self.bench = bench
        self._servos, self._joints = servos, joints
        self._now: float | None = None
        self._owed_s = 0.0
        self.frames: list[Floats] = [bench.markers()]
        for servo, joint in zip(servos, joints, strict=True):
            servo.motion = Shaft(float(joint.zero_ticks))

    def advance(self, now: float) -> None:
        """Move the robot up to time `now` [s] and tell the shafts where they are."""
        self._owed_s += 0.0 if self._now is None else min(LONGEST_S, max(0.0, now - self._now))
        self._now = now
        while self._owed_s >= FRAME_S:
            self._owed_s -= FRAME_S
            self._move()

    def write_motion(self, path: Path) -> None:
        """Marker positions as a tidy CSV: t_s, x_0, y_0, ... [s, m], vertex 0 = tail."""
        header = ["t_s", *(f"{axis}_{vertex}" for vertex in range(len(self.frames[0])) for axis in "xy")]
        rows = [[n * FRAME_S, *frame[:, :2].ravel().tolist()] for n, frame in enumerate(self.frames)]
        write_csv(path, header, rows)

    def _move(self) -> None:
        for number, (servo, joint) in enumerate(zip(self._servos, self._joints, strict=True), 1):
            self.bench.set_torque(number, servo.torque)
            self.bench.set_goal_ticks(number, CENTRE + joint.sign * (servo.motion.profile - joint.zero_ticks))
        self.bench.step(FRAME_S)
        for number, (servo, joint) in enumerate(zip(self._servos, self._joints, strict=True), 1):
            away = self.bench.position_ticks(number) - CENTRE
            servo.motion.position = float(joint.zero_ticks + joint.sign * away)
            servo.motion.velocity = joint.sign * self.bench.velocity_ticks_per_s(number)
        self.frames.append(self.bench.markers())
