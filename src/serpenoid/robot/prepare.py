"""Before anything moves: are these the right servos, healthy, fed, and set up as the robot file says?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from serpenoid.robot.bus import Bus
from serpenoid.robot.bus.bus import NO_ANSWER
from serpenoid.robot.checks import Refusal, check_voltage
from serpenoid.robot.description import Robot
from serpenoid.robot.faults import BusFault, PortLost, RobotFault
from serpenoid.robot.models import ServoModel, by_number
from serpenoid.robot.plan import Plan
from serpenoid.robot.stop import StopWatcher


def set_up(bus: Bus, plan: Plan, stop: StopWatcher) -> tuple[Plan, list[str]]:
    """Identify, inspect, then write limits and modes with torque off. Raise RobotFault with all that is wrong.

    Returns the plan within the limits that hold, and what was found or written that the user should know.
    """
    refuse(identify(bus, plan.robot))
    refuse(inspect(bus, plan.robot))
    robot, notes = (plan.robot, []) if plan.widen_limits else narrower(bus, plan.robot)
    plan = replace(plan, robot=robot)
    ids, servos = plan.robot.ids, plan.robot.servos
    for servo_id in ids:
        bus.write(servo_id, "torque_enable", 0)
        bus.write(servo_id, "bus_watchdog", 0)  # clears a trip that an earlier, killed run left behind
        bus.write(servo_id, "profile_acceleration", 0)
    for register, values in plan.settings().items():
        for servo_id, servo, value in zip(ids, servos, values, strict=True):
            stop.check()
            before = bus.read(servo_id, register)
            if before != value:  # EEPROM wears out: write only what differs
                bus.write(servo_id, register, value)
                if before != servo.registers[register].initial:  # somebody set it
                    label = plan.robot.joint_label(ids.index(servo_id))
                    notes.append(f"{label}: {register} {before} -> {value} written to its memory")
    return plan, notes


def narrower(bus: Bus, robot: Robot) -> tuple[Robot, list[str]]:
    """The robot within the limits that its servos keep in their own memory, and a word about each narrower one."""
    joints, notes = [], []
    for j, joint in enumerate(robot.joint):
        low, high = (bus.read(joint.id, f"{end}_position_limit") for end in ("minimum", "maximum"))
        speed, servo = bus.read(joint.id, "velocity_limit"), joint.servo
        own: dict[str, float] = {}
        if low > joint.minimum_ticks:
            own["minimum_ticks"] = low
        if high < joint.maximum_ticks:
            own["maximum_ticks"] = high
        factory = servo.registers["velocity_limit"].initial
        if speed < joint.velocity_units(joint.speed_limit_rpm) and speed < factory:
            own["speed_limit_rpm"] = speed * joint.rpm_per_velocity_unit
        said = [f"`{name}` is {value:.4g}, not {getattr(joint, name):g}" for name, value in own.items()]
        if said:
            holds = "the narrower limit holds (--widen-limits writes the robot file's)"
            notes.append(f"{robot.joint_label(j)}: in its own memory {', '.join(said)}: {holds}")
        joints.append(joint.model_copy(update=own))
    return robot.model_copy(update={"joint": joints}), notes


def set_profile(bus: Bus, plan: Plan, velocity: Sequence[int]) -> None:
    """Profile Velocity is RAM, and a tripped watchdog sets it to 0, which means full speed: write it every time."""
    for servo_id, value in zip(plan.robot.ids, velocity, strict=True):
        bus.write(servo_id, "profile_velocity", value)


def identify(bus: Bus, robot: Robot) -> list[Refusal]:
    """Ping each servo: presence, model, firmware. Of a bus on which none answers one refusal says so."""
    refusals, silent = [], 0
    for j, joint in enumerate(robot.joint):
        label, servo_id = f"{robot.joint_label(j)}, before step 0", joint.id
        try:
            number = bus.ping(servo_id)
            firmware = bus.read(servo_id, "firmware_version")
        except PortLost:
            raise
        except BusFault as fault:
            remedy = "Check power and cable, and whether two servos have this ID: serpenoid robot scan."
            refusals.append(Refusal(label, str(fault).rstrip("."), f"expected at {robot.bus.baud_rate} baud", remedy))
            silent += NO_ANSWER in str(fault)
            continue
        if number != joint.servo.number:
            refusals.append(_another_model(label, number, joint.servo))
        elif firmware < joint.servo.oldest_firmware:
            limit = f"the oldest that serves is {joint.servo.oldest_firmware}"
            refusals.append(Refusal(label, f"firmware {firmware}", limit, "Update it with DYNAMIXEL Wizard 2.0."))
    return [_none_answers(robot)] if silent == len(robot.joint) > 1 else refusals


def _none_answers(robot: Robot) -> Refusal:
    """What all servos share: power, the cable to them, their baud rate."""
    where, asked = "the bus, before step 0", f"asked for IDs {', '.join(map(str, robot.ids))}"
    remedy = "Is the battery on, the cable in, and is this their baud rate? serpenoid robot scan tries others."
    return Refusal(where, f"no servo answers at {robot.bus.baud_rate} baud", asked, remedy)


def _another_model(label: str, number: int, wanted: ServoModel) -> Refusal:
    """A servo that is not what the robot file says."""
    found = by_number(number)
    value = f"model number {number}" + (f", an {found.name}" if found is not None else ", which is not known here")
    remedy = "Correct the ID or the servo"
    if found is not None:
        remedy += f', or write model = "{found.name}" in the robot file (in its [[joint]] if others differ)'
    return Refusal(label, value, f"`model` is {wanted.name} ({wanted.number})", f"{remedy}.")


def inspect(bus: Bus, robot: Robot) -> list[Refusal]:
    """Voltage and hardware errors."""
    states = bus.read_states(robot.ids)
    refusals = check_voltage(np.array([states[servo_id].voltage for servo_id in robot.ids]), robot)
    for j, joint in enumerate(robot.joint):
        bits = bus.read_health(joint.id).hardware_error
        if bits:
            remedy, trouble = "Then reboot it: serpenoid robot reboot.", joint.servo.name_hardware_errors(bits)
            refusals.append(Refusal(f"{robot.joint_label(j)}, before step 0", trouble, "no error", remedy))
    return refusals


def refuse(refusals: Sequence[Refusal], notes: Sequence[str] = ()) -> None:
    if refusals:
        raise RobotFault("\n".join(["refused, nothing has moved:", *map(str, refusals), *notes]))
