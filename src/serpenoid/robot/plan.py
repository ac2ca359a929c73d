"""What will be sent and when: the schedule of a trial, the servo settings, and what the bus allows.

At `t0` the first step begins; row `i` of cycle `n` is due at `t0 + n (cycle + pause) + i cycle / T`; row 0 is commanded
again at the end of each cycle and held for the pause (docs/campaign-format.md). A transient has a row more, which is
commanded and held there instead.  T: steps, m: joints.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import NDArray

from serpenoid.errors import InputError
from serpenoid.joint_limits import travels
from serpenoid.robot.description import Robot
from serpenoid.robot.ticks import to_ticks

READING_INTERVAL_S = 0.1  # the servos are read at least this often, which also feeds their watchdogs
SPEED_RESERVE = 1.2  # profile velocity over the table's own peak speed: room to catch up with a late row
BITS_PER_BYTE = 10
RETURN_DELAY_UNITS = 10  # 20 us before a servo answers


@dataclass(frozen=True)
class RowCommand:
    """Goal positions (m,) [ticks] due `time` [s] after t0."""

    time: float
    phase: str
    cycle: int
    step: int
    goals: NDArray[np.int64]


@dataclass(frozen=True)
class Plan:
    """A trial as it will be played; `ticks` (T, m), of a transient (T + 1, m)."""

    robot: Robot
    ticks: NDArray[np.int64]
    cycle_duration_s: float
    cycles: int
    pause_s: float
    widen_limits: bool = False  # write the robot file's limits over narrower ones in the servos' own memory
    closed: bool = True  # False: a transient

    @property
    def steps(self) -> int:
        return len(self.ticks) - (not self.closed)

    @property
    def end_row(self) -> int:
        """Index of the row that is commanded at the end of a cycle."""
        return 0 if self.closed else self.steps

    @property
    def row_period_s(self) -> float:
        return self.cycle_duration_s / self.steps

    @property
    def duration_s(self) -> float:
        return self.cycles * (self.cycle_duration_s + self.pause_s)

    @property
    def end_s(self) -> float:
        """When torque goes off: the last row has at least a row's time to be reached."""
        return self.duration_s + max(0.0, self.row_period_s - self.pause_s)

    @property
    def most_readings(self) -> int:
        """Readings while the gait is played: one a row, and in long rows and pauses one in `READING_INTERVAL_S`."""
        return self.steps * self.cycles + ceil(self.end_s / READING_INTERVAL_S)

    @property
    def watchdog_units(self) -> list[int]:
        """Bus Watchdog (98) of each joint."""
        return [ceil(self.robot.motion.watchdog_s / servo.watchdog_unit_s - 1e-9) for servo in self.robot.servos]

    @property
    def watchdog_s(self) -> float:
        """The longest silence after which every servo has stopped."""
        servos = self.robot.servos
        return max(u * servo.watchdog_unit_s for u, servo in zip(self.watchdog_units, servos, strict=True))

    def rows(self) -> Iterator[RowCommand]:
        """Every row in the order in which it is sent."""
        for cycle in range(self.cycles):
            start = cycle * (self.cycle_duration_s + self.pause_s)
            for step in range(self.steps):
                yield RowCommand(start + step * self.row_period_s, "play", cycle, step, self.ticks[step])
            if self.pause_s > 0 or cycle == self.cycles - 1:
                phase = "pause" if self.pause_s > 0 else "end"
                yield self.end(start + self.cycle_duration_s, phase, cycle)

    def end(self, time: float, phase: str, cycle: int) -> RowCommand:
        """What is held when a cycle has been played."""
        return RowCommand(time, phase, cycle, self.steps, self.ticks[self.end_row])

    def peak_speed_rpm(self) -> NDArray[np.float64]:
        """Fastest step of each joint (m,), in a closed table the one from the last row to the first among them."""
        return row_speeds_rpm(self.ticks, self.robot, self.cycle_duration_s, self.closed).max(axis=0)

    def approach_velocity(self) -> list[int]:
        """Profile Velocity (112) on the way to the first row."""
        return [joint.velocity_units(self.robot.motion.approach_speed_rpm) for joint in self.robot.joint]

    def play_velocity(self) -> list[int]:
        """Profile Velocity (112) while playing: enough for the table, never above the joint's limit."""
        return [
            joint.velocity_units(min(SPEED_RESERVE * peak, joint.speed_limit_rpm))
            for peak, joint in zip(self.peak_speed_rpm(), self.robot.joint, strict=True)
        ]

    def settings(self) -> dict[str, list[int]]:
        """Register -> value per joint, written with torque off and only where it differs."""
        joints = self.robot.joint
        return {
            "return_delay_time": [RETURN_DELAY_UNITS] * len(joints),
            "drive_mode": [0] * len(joints),
            "operating_mode": [joint.servo.position_mode for joint in joints],
            "homing_offset": [0] * len(joints),
            "velocity_limit": [joint.velocity_units(joint.speed_limit_rpm) for joint in joints],
            "minimum_position_limit": [joint.minimum_ticks for joint in joints],
            "maximum_position_limit": [joint.maximum_ticks for joint in joints],
        }


def make_plan(
    angles: NDArray[np.float64],
    robot: Robot,
    cycle_duration_s: float,
    cycles: int,
    pause_s: float,
    widen_limits: bool = False,
    closed: bool = True,
) -> Plan:
    """Plan a checked table (`checks.check_table` first: shape and finiteness are its matter)."""
    check_repetition(cycles, pause_s)
    return Plan(robot, to_ticks(angles, robot), cycle_duration_s, cycles, pause_s, widen_limits, closed)


def check_repetition(cycles: int, pause_s: float) -> None:
    if not 1 <= cycles <= 10000:
        raise InputError(f"--cycles must be between 1 and 10000, got {cycles}.")
    if not 0 <= pause_s <= 600:
        raise InputError(f"--pause must be between 0 and 600 seconds, got {pause_s}.")


def row_speeds_rpm(
    ticks: NDArray[np.int64], robot: Robot, cycle_duration_s: float, closed: bool
) -> NDArray[np.float64]:
    """Speed (T, m) of every step: from each row to the next, and in a closed table from the last to the first."""
    steps = travels(ticks, closed)
    per_turn = np.array([joint.ticks_per_turn for joint in robot.joint])
    return np.asarray(steps * (len(steps) * 60.0 / (per_turn * cycle_duration_s)))


def velocity_unit(robot: Robot) -> str:
    """Of Velocity Limit (44) and Profile Velocity (112): `0.229 rpm`."""
    return ", ".join(dict.fromkeys(f"{kind.rpm_per_velocity_unit:g} rpm" for kind in robot.kinds))


def write_time_s(robot: Robot) -> float:
    """One sync write of a row: 14 bytes, and the ID and the goal of each servo."""
    goal = robot.servos[0].shared.goal
    return (14 + (1 + goal.size) * len(robot.joint)) * BITS_PER_BYTE / robot.bus.baud_rate


def read_time_s(robot: Robot) -> float:
    """One sync read of all states and one servo's health: questions, answers, return delays."""
    joints = len(robot.joint)
    state = 14 + joints + sum(11 + servo.state.size for servo in robot.servos)
    health = 14 + 11 + max(servo.health.size for servo in robot.servos)
    return (state + health) * BITS_PER_BYTE / robot.bus.baud_rate + (joints + 1) * RETURN_DELAY_UNITS * 2e-6
