"""Before anything moves: are these the right servos, healthy, fed, and set up as the robot file says?"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.robot.bus import Bus
from serpenoid.robot.checks import Refusal, check_voltage
from serpenoid.robot.control_table import MODEL_NAME, MODEL_NUMBER, OLDEST_FIRMWARE, name_hardware_errors
from serpenoid.robot.description import Robot
from serpenoid.robot.faults import BusFault, PortLost, RobotFault
from serpenoid.robot.plan import Plan
from serpenoid.robot.stop import StopWatcher


def set_up(bus: Bus, plan: Plan, stop: StopWatcher) -> None:
    """Identify, inspect, then write limits and modes with torque off. Raise RobotFault with all that is wrong."""
    refuse(identify(bus, plan.robot))
    refuse(inspect(bus, plan.robot))
    ids = plan.robot.ids
    for servo_id in ids:
        bus.write(servo_id, "torque_enable", 0)
        bus.write(servo_id, "bus_watchdog", 0)  # clears a trip that an earlier, killed run left behind
        bus.write(servo_id, "profile_acceleration", 0)
    for register, values in plan.settings().items():
        for servo_id, value in zip(ids, values, strict=True):
            stop.check()
            if bus.read(servo_id, register) != value:  # EEPROM wears out: write only what differs
                bus.write(servo_id, register, value)


def set_profile(bus: Bus, plan: Plan, velocity: Sequence[int]) -> None:
    """Profile Velocity is RAM, and a tripped watchdog sets it to 0, which means full speed: write it every time."""
    for servo_id, value in zip(plan.robot.ids, velocity, strict=True):
        bus.write(servo_id, "profile_velocity", value)


def identify(bus: Bus, robot: Robot) -> list[Refusal]:
    """Ping each servo: presence, model, firmware."""
    refusals = []
    for j, servo_id in enumerate(robot.ids):
        label = f"{robot.joint_label(j)}, before step 0"
        try:
            model = bus.ping(servo_id)
            firmware = bus.read(servo_id, "firmware_version")
        except PortLost:
            raise
        except BusFault as fault:
            remedy = "Check power, cable and ID: serpenoid robot scan."
            refusals.append(Refusal(label, str(fault).rstrip("."), f"expected at {robot.bus.baud_rate} baud", remedy))
            continue
        if model != MODEL_NUMBER:
            limit = f"`model` is {MODEL_NAME} ({MODEL_NUMBER})"
            refusals.append(Refusal(label, f"model number {model}", limit, "Correct the ID or the servo."))
        if firmware < OLDEST_FIRMWARE:
            limit = f"the oldest that serves is {OLDEST_FIRMWARE}"
            refusals.append(Refusal(label, f"firmware {firmware}", limit, "Update it with DYNAMIXEL Wizard 2.0."))
    return refusals


def inspect(bus: Bus, robot: Robot) -> list[Refusal]:
    """Voltage and hardware errors."""
    states = bus.read_states(robot.ids)
    refusals = check_voltage(np.array([states[servo_id].voltage for servo_id in robot.ids]), robot)
    for j, servo_id in enumerate(robot.ids):
        bits = bus.read_health(servo_id).hardware_error
        if bits:
            remedy = "Then reboot it: serpenoid robot reboot."
            refusals.append(
                Refusal(f"{robot.joint_label(j)}, before step 0", name_hardware_errors(bits), "no error", remedy)
            )
    return refusals


def refuse(refusals: Sequence[Refusal]) -> None:
    if refusals:
        raise RobotFault("refused, nothing has moved:\n" + "\n".join(map(str, refusals)))
