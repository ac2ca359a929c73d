"""The servos under way: health, battery and reliability, judged after every reading."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from serpenoid.robot.bus import Bus, ServoHealth, ServoState
from serpenoid.robot.faults import RobotFault
from serpenoid.robot.plan import Plan

LOW_VOLTAGE_READINGS = 3  # a moment's sag is no empty battery
UNRELIABLE = 6.0  # failed readings of one servo, each answered one taking back this share of one:
FADING = 0.25


class ServoWatch:
    """Asks one servo after the other how it is, those that raise an alert at once; raises RobotFault."""

    def __init__(self, bus: Bus, plan: Plan) -> None:
        self._bus, self._plan, self._ids = bus, plan, plan.robot.ids
        self._next_health = 0
        self._low_readings = 0
        self._unreliability = [0.0] * len(self._ids)

    def judge(self, healths: Mapping[int, ServoHealth], states: Mapping[int, ServoState], failed: set[int]) -> None:
        """`failed`: servos that had to be asked again in this reading."""
        self._refuse_sick(healths, states)
        self._refuse_low_voltage(states)
        self._refuse_unreliable(failed)

    def ask(self, states: Mapping[int, ServoState]) -> dict[int, ServoHealth]:
        """The health of every servo that raises its alert bit, and of one more in turn."""
        turn = self._ids[self._next_health % len(self._ids)]
        self._next_health += 1
        wanted = [i for i in self._ids if states[i].alert or i == turn]
        return {i: self._bus.read_health(i) for i in wanted}

    def _refuse_sick(self, healths: Mapping[int, ServoHealth], states: Mapping[int, ServoState]) -> None:
        for servo_id, health in healths.items():
            joint = self._ids.index(servo_id)
            label = self._plan.robot.joint_label(joint)
            if health.hardware_error:
                state = f"{states[servo_id].temperature} deg C, {states[servo_id].voltage:.1f} V"
                trouble = self._plan.robot.servos[joint].name_hardware_errors(health.hardware_error)
                raise RobotFault(f"{label} protects itself: {trouble}; {state}. Then: serpenoid robot reboot.")
            if health.watchdog_tripped:
                raise RobotFault(
                    f"{label}: its bus watchdog tripped: it heard nothing for {self._plan.watchdog_s:.2f} s."
                )
            if not health.torque:
                raise RobotFault(f"{label} has lost its torque without an error: did its power fail for a moment?")

    def _refuse_low_voltage(self, states: Mapping[int, ServoState]) -> None:
        volts = float(np.median([state.voltage for state in states.values()]))
        minimum = self._plan.robot.voltage.minimum_V
        self._low_readings = self._low_readings + 1 if volts < minimum else 0
        if self._low_readings >= LOW_VOLTAGE_READINGS:
            raise RobotFault(
                f"battery: {volts:.1f} V at the servos, `minimum_V` is {minimum:g} V. Charge it and play again."
            )

    def _refuse_unreliable(self, failed: set[int]) -> None:
        """A servo that answers only when asked again, reading after reading; single failures fade away.

        Servos answer in turn: one that is late holds up those behind it, which are not to blame.
        """
        for j, i in enumerate(self._ids):
            at_fault = i in failed and not (j and self._ids[j - 1] in failed)
            score = self._unreliability[j] + (1.0 if at_fault else -FADING)
            self._unreliability[j] = max(0.0, score)
            if score >= UNRELIABLE:
                text = "answers late or corrupt, reading after reading"
                raise RobotFault(f"{self._plan.robot.joint_label(j)} {text}. Check its cable and its plugs.")
