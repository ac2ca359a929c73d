"""The arena under the emulated servo bus: `play` talks to emulated servos, and they move the arena's robot.

The emulator keeps control tables, profiles, watchdogs and protection; shafts are turned by the arena's motors against
the arena's floor. The robot moves in a process of its own, camera frame by camera frame after the emulator's clock:
an answer on the bus is due within milliseconds, and a frame must not hold it up.
"""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from serpenoid.arena import mujoco_module
from serpenoid.arena.assembly import Assembly
from serpenoid.arena.bench import CENTRE, Bench
from serpenoid.arena.robot import Robot
from serpenoid.errors import InputError
from serpenoid.files.writing import write_csv
from serpenoid.parallel.local import interrupts_held, watch_parent
from serpenoid.robot.description import JointServo
from serpenoid.robot.emulator.motion import Motion
from serpenoid.robot.emulator.servo import EmulatedServo

MOTORS = "XL430-W250-T"  # whose data sheet `arena.robot` has
FRAME_S = 1 / 120
LONGEST_S = 1.0  # a lag behind the clock longer than this is not caught up with
PATIENCE_S = 0.002
NOW = 0  # places in the shared numbers: the time, then of every servo
GOAL, TORQUE, POSITION, SPEED = range(1, 5)


class Shaft(Motion):
    """A shaft that the arena turns: only its profile is walked here."""

    def advance(self, duration: float, goal: float, velocity: int, acceleration: int, voltage: float) -> None:
        self.walk_profile(duration, goal, velocity, acceleration, voltage)

    def rest(self) -> None:
        self.profile = self.position
        self._profile_velocity = 0.0


class Ground:
    """The robot that the emulated servos are built into, filmed by ideal cameras."""

    def __init__(self, servos: Sequence[EmulatedServo], joints: Sequence[JointServo], robot: Robot) -> None:
        mujoco_module()
        if len(joints) != robot.servos:
            remedy = "Name the robot's own body with --problem FILE."
            raise InputError(f"--robot has {len(joints)} joints, the arena's robot {robot.servos}. {remedy}")
        if any(joint.gear_ratio != 1 for joint in joints):
            raise InputError("--arena: its robot's motors turn its joints directly: leave `gear_ratio` out.")
        strange = [servo.model.name for servo in servos if servo.model.name != MOTORS]
        if strange:
            remedy = "Leave --arena out: shafts then turn freely"
            raise InputError(f"--arena: its robot has motors of {MOTORS}, not of {strange[0]} servos. {remedy}.")
        self._pairs = list(zip(servos, joints, strict=True))
        for servo, joint in self._pairs:
            servo.motion = Shaft(float(joint.zero_ticks), servo.model)
        context = multiprocessing.get_context("spawn")
        self._numbers = context.Array("d", 1 + 4 * robot.servos, lock=False)
        self._ended = context.Event()
        self._mail, theirs = context.Pipe()
        self._process = context.Process(target=_drive, args=(robot, self._numbers, self._ended, theirs), daemon=True)
        with interrupts_held():
            self._process.start()
        theirs.close()
        self._mail.recv()  # it stands on the floor

    def advance(self, now: float) -> None:
        """Let the robot move up to time `now` [s], and tell the shafts where they are by now."""
        numbers = self._numbers
        for index, (servo, joint) in enumerate(self._pairs):
            numbers[_at(GOAL, index)] = joint.sign * (servo.motion.profile - joint.zero_ticks)
            numbers[_at(TORQUE, index)] = float(servo.torque)
            servo.motion.position = joint.zero_ticks + joint.sign * numbers[_at(POSITION, index)]
            servo.motion.velocity = joint.sign * numbers[_at(SPEED, index)]
        numbers[NOW] = now

    def close(self, motion: Path | None = None) -> None:
        """Stop; write marker positions as a tidy CSV (t_s, x_0, y_0, ... [s, m], vertex 0 = tail) if asked."""
        self._ended.set()
        try:
            frames, complaint = self._mail.recv()
        except EOFError:
            raise InputError("the arena's process was killed: its motion is lost.") from None
        self._process.join()
        if motion is not None and frames:
            header = ["t_s", *(f"{axis}_{vertex}" for vertex in range(len(frames[0])) for axis in "xy")]
            write_csv(motion, header, [[n * FRAME_S, *frame.ravel().tolist()] for n, frame in enumerate(frames)])
        if complaint:
            raise InputError(complaint)


def _drive(robot: Robot, numbers: Any, ended: Any, mail: Any) -> None:
    """The arena's process: follow the clock, send the frames at the end."""
    watch_parent()
    bench = Bench(Assembly.healthy(robot))
    frames = [bench.markers()[:, :2]]
    mail.send("ready")
    reached, complaint = 0.0, ""
    while not ended.is_set() and not complaint:
        now = numbers[NOW]
        if now - reached < FRAME_S:
            time.sleep(PATIENCE_S)
            continue
        reached = max(now - LONGEST_S, reached + FRAME_S) if reached else now
        try:
            _move(bench, numbers)
        except InputError as error:
            complaint = str(error)
        frames.append(bench.markers()[:, :2])
    mail.send((frames, complaint))


def _at(what: int, servo: int) -> int:
    return 4 * servo + what


def _move(bench: Bench, numbers: Any) -> None:
    for index in range(bench.servos):
        bench.set_torque(index + 1, bool(numbers[_at(TORQUE, index)]))
        bench.set_goal_ticks(index + 1, CENTRE + numbers[_at(GOAL, index)])
    bench.step(FRAME_S)
    for index in range(bench.servos):
        numbers[_at(POSITION, index)] = bench.position_ticks(index + 1) - CENTRE
        numbers[_at(SPEED, index)] = bench.velocity_ticks_per_s(index + 1)
