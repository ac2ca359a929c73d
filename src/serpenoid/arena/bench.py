"""The arena behind a servo bus: goals in ticks per servo, time in any portions, readings as registers give them.

bench = Bench()                     # the healthy robot, or Bench(assembly)
bench.set_goal_ticks(3, 2200)       # servo 3 counted from the tail; 2048 is straight
bench.step(0.004)
bench.position_ticks(3), bench.load(3), bench.voltage(3)
"""

from __future__ import annotations

import numpy as np

from serpenoid.arena.assembly import Assembly
from serpenoid.arena.robot import TICK, TICKS, Robot
from serpenoid.arena.world import World
from serpenoid.body import Floats
from serpenoid.errors import InputError

CENTRE = TICKS // 2


class Bench:
    """The servos under one robot on the floor; joint 1 is next to the tail. A servo without torque gives way."""

    def __init__(self, assembly: Assembly | None = None) -> None:
        self.world = World(assembly or Assembly.healthy(Robot(profile_s=0.0)))
        self.servos = self.world.robot.servos
        self.world.place(np.zeros(self.servos))
        self._goals = np.zeros(self.servos)
        self._torque = np.ones(self.servos, dtype=bool)
        self._gain = self.world.model.actuator_gainprm[:, 0].copy()
        self._debt_s = 0.0

    def set_goal_ticks(self, joint: int, ticks: float) -> None:
        """The position to go to next; the servo's own profile, if any, is the caller's to walk."""
        self._goals[self._index(joint)] = (ticks - CENTRE) * TICK

    def set_torque(self, joint: int, on: bool) -> None:
        """Switch a motor; without torque only its gears' friction holds the joint."""
        index = self._index(joint)
        self._torque[index] = on
        gain = self._gain[index] if on else 0.0
        self.world.model.actuator_gainprm[index, 0] = gain
        self.world.model.actuator_biasprm[index, 1] = -gain

    def step(self, duration_s: float) -> None:
        """Let time pass; what does not fill a time step is kept for the next call."""
        self._debt_s += duration_s
        self.world.command(self._goals)
        timestep = self.world.robot.timestep_s
        while self._debt_s >= timestep - 1e-9:
            self.world.step()
            self._debt_s -= timestep

    def position_ticks(self, joint: int) -> int:
        return CENTRE + round(float(self.world.angles()[self._index(joint)]) / TICK)

    def velocity_ticks_per_s(self, joint: int) -> float:
        return float(self.world.speeds()[self._index(joint)]) / TICK

    def load(self, joint: int) -> float:
        """Share of the full voltage, -1..1."""
        return float(self.world.duty()[self._index(joint)])

    def voltage(self, joint: int) -> float:
        """At the servo's terminals [V]; the same for all, on one battery."""
        self._index(joint)
        return self.world.voltage()

    def markers(self) -> Floats:
        """Where the robot is: marker positions (N, 3) [m]."""
        return self.world.markers()

    def _index(self, joint: int) -> int:
        if not 1 <= joint <= self.servos:
            raise InputError(f"`joint` must be 1 (next to the tail) to {self.servos}, got {joint}.")
        return joint - 1
