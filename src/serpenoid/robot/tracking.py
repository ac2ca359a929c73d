"""How far each joint stands from its command, its lag apart, and what is done when that is too far.

A servo that follows within `lag_s` stands, at any moment, where some command of the last `lag_s` seconds has been:

    error_j = distance of position_j from the interval that command_j ran through in that time

So a fast gait is not blamed for its lag, and what remains is what torque could not do. Where a cycle is so short that
`lag_s` covers much of it, travel tells: over a whole cycle a joint must move if its command moves by `limit_deg`.
m: joints.
"""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from serpenoid.robot.description import Robot
from serpenoid.robot.faults import RobotFault
from serpenoid.robot.ticks import radians_per_tick

STILL_TICKS = 3  # over a whole cycle: the shaft did not move
WHOLE = 0.9  # of a cycle between the first and the last of its readings
READINGS = 3  # running: a joint that catches on the floor for a moment is not stuck
SLOWER = 1.5  # each time the gait is slowed down
UNSEEN_DEG = 0.05  # what reads 0.0
SLOWEST = 4.0  # times its duration; a joint that is still too far off is not slow but stuck

Ticks = NDArray[np.int64]


class Tracking:
    """Told of every row sent and every position read; raises RobotFault where the robot file says `stop`."""

    def __init__(self, robot: Robot, cycle_s: float) -> None:
        self._robot, self._cycle_s = robot, cycle_s
        self._limits, self._tick = robot.tracking_limits_deg, radians_per_tick(robot)  # (m,) [degrees], [rad]
        self._cycle: deque[tuple[float, Ticks, Ticks]] = deque()  # moment, command, position
        self._sent: deque[tuple[float, Ticks]] = deque()
        self._running = 0
        self.worst = np.zeros(len(robot.joint))  # [degrees]
        self.strayed: list[str] = []
        self.stretch = 1.0  # times the duration that was asked for

    def sent(self, moment: float, goals: Ticks) -> None:
        """A row left at monotonic time `moment` [s]; goals (m,) [ticks]."""
        self._sent.append((moment, goals))

    def read(self, moment: float, positions: Ticks) -> None:
        """Positions (m,) [ticks] at monotonic time `moment` [s]."""
        error = self._error(moment, positions)
        blocked = self._blocked(moment, positions)
        self.worst = np.maximum(self.worst, error)
        beyond = error - self._limits
        self._running = self._running + 1 if beyond.max() > 0 else 0
        if self._running == READINGS:
            worst = int(beyond.argmax())
            self._act(worst, f"is {error[worst]:.1f} degrees off its command")
        elif blocked.max() > 0:
            self._act(int(blocked.argmax()), f"did not move in a whole cycle of {blocked.max():.1f} degrees")

    def _error(self, moment: float, positions: Ticks) -> NDArray[np.float64]:
        begin = moment - self._robot.tracking.lag_s
        while len(self._sent) > 1 and self._sent[1][0] <= begin:
            self._sent.popleft()
        commands = np.array([goals for _, goals in self._sent])
        off = np.maximum(commands.min(axis=0) - positions, positions - commands.max(axis=0))
        return np.degrees(np.maximum(off, 0) * self._tick)

    def _blocked(self, moment: float, positions: Ticks) -> NDArray[np.float64]:
        """Commanded travel over the last cycle [degrees] of joints that stood still in it, else 0, shape (m,)."""
        self._cycle.append((moment, self._sent[-1][1], positions))
        while moment - self._cycle[0][0] > self._cycle_s * self.stretch:
            self._cycle.popleft()
        moments, commands, places = zip(*self._cycle, strict=True)
        if moments[-1] - moments[0] < WHOLE * self._cycle_s * self.stretch:
            return np.zeros(len(positions))
        travel = np.degrees(np.ptp(commands, axis=0) * self._tick)
        still = np.ptp(places, axis=0) <= STILL_TICKS
        return np.where(still & (travel > self._limits), travel, 0.0)

    def _act(self, joint: int, fault: str) -> None:
        self._running = 0
        self._cycle.clear()
        label, rule = self._robot.joint_label(joint), self._robot.tracking
        what = f"{label} {fault}, `limit_deg` in [tracking] is {self._limits[joint]:g}"
        if rule.action == "stop" or (rule.action == "slow" and self.stretch * SLOWER > SLOWEST):
            slowed = f", though the gait was slowed down {self.stretch:.2g} times" if self.stretch > 1 else ""
            raise RobotFault(f"{what}{slowed}. Is it blocked, overloaded, or its horn loose?")
        if label not in self.strayed:
            self.strayed.append(label)
        if rule.action == "slow":
            self.stretch *= SLOWER

    def sentence(self) -> str:
        """For the summary."""
        joint = int((self.worst - self._limits).argmax())
        label, limit = self._robot.joint_label(joint), f"the limit is {self._limits[joint]:g}"
        worst = f"largest error beyond the lag {self.worst[joint]:.1f} degrees, {label} ({limit})"
        if self.worst.max() < UNSEEN_DEG:
            worst = f"no joint differs from its command beyond the lag ({limit} degrees)"
        return worst + (f"; slowed down {self.stretch:.2g} times" if self.stretch > 1 else "")

    def summary(self) -> dict[str, object]:
        """For play.json."""
        worst = [round(float(degrees), 2) for degrees in self.worst]
        return {"worst_deg": worst, "strayed": self.strayed, "slowed_down": round(self.stretch, 3)}


class RowClock:
    """When rows are due: monotonic time of a row's own time [s], slower from some moment on if asked."""

    def __init__(self, start: float) -> None:
        self._at, self._since, self._stretch = start, 0.0, 1.0

    def due(self, time: float) -> float:
        """Monotonic time [s]."""
        return self._at + (time - self._since) * self._stretch

    def stretch(self, factor: float, time: float) -> None:
        """From row time `time` on everything takes `factor` times as long as planned."""
        self._at, self._since, self._stretch = self.due(time), time, factor
