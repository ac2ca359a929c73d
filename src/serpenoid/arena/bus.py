"""The arena under the emulated servo bus: `play` talks to emulated servos, and they move the arena's robot.

The emulator keeps control tables, profiles, watchdogs and protection; shafts are turned by the arena's motors against
the arena's floor. The robot moves in a thread of its own, camera frame by camera frame after the emulator's clock, so
that the servos answer in time however long a frame takes.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Sequence
from pathlib import Path

from serpenoid.arena.bench import CENTRE, Bench
from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.files import write_csv
from serpenoid.robot.description import JointServo
from serpenoid.robot.emulator.motion import Motion
from serpenoid.robot.emulator.servo import EmulatedServo

FRAME_S = 1 / 120
LONGEST_S = 0.25  # a lag behind the clock longer than this is not caught up with
PATIENCE_S = 0.002
SWITCH_S = 0.0002  # an answer is due within a millisecond or two; a frame must not hold it up for five


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
        self._ended = threading.Event()
        self._error: Exception | None = None
        self._thread = threading.Thread(target=self._follow, daemon=True)
        self.frames: list[Floats] = [bench.markers()]
        for servo, joint in zip(servos, joints, strict=True):
            servo.motion = Shaft(float(joint.zero_ticks))
        sys.setswitchinterval(SWITCH_S)
        self._thread.start()

    def advance(self, now: float) -> None:
        """Let the robot move up to time `now` [s]; it tells the shafts where they are when it gets there."""
        self._now = now

    def close(self) -> None:
        """Stop moving; raise what went wrong on the way."""
        self._ended.set()
        self._thread.join()
        if self._error is not None:
            raise self._error

    def write_motion(self, path: Path) -> None:
        """Marker positions as a tidy CSV: t_s, x_0, y_0, ... [s, m], vertex 0 = tail."""
        header = ["t_s", *(f"{axis}_{vertex}" for vertex in range(len(self.frames[0])) for axis in "xy")]
        rows = [[n * FRAME_S, *frame[:, :2].ravel().tolist()] for n, frame in enumerate(self.frames)]
        write_csv(path, header, rows)

    def _follow(self) -> None:
        reached: float | None = None
        while not self._ended.is_set() and self._error is None:
            now = self._now
            if now is None or (reached is not None and now - reached < FRAME_S):
                self._ended.wait(PATIENCE_S)
                continue
            reached = max(now - LONGEST_S, now if reached is None else reached + FRAME_S)
            try:
                self._move()
            except InputError as error:
                self._error = error

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
