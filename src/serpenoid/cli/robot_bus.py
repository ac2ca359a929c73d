"""`serpenoid robot scan | check | off | reboot | power`: short conversations with the bus."""

from __future__ import annotations

import argparse
import sys
from typing import Any

import numpy as np

from serpenoid.cli.robot_arguments import add_robot, add_table, checked_table, cycle_duration, load_robot, warn
from serpenoid.cli.target import target
from serpenoid.robot.bus import COLLISION_REMEDY, Bus, open_bus
from serpenoid.robot.checks import Refusal, check_start, check_table
from serpenoid.robot.description import Robot
from serpenoid.robot.faults import PortLost, RobotFault
from serpenoid.robot.models import by_number
from serpenoid.robot.port import resolve_port
from serpenoid.robot.power import record_power
from serpenoid.robot.prepare import identify, inspect, narrower
from serpenoid.robot.table import JointTable
from serpenoid.robot.ticks import to_ticks
from serpenoid.wording import counted

LAST_ID = 252
SCAN_RATES = (57600, 1000000, 115200, 2000000, 3000000)

CHECK = """Say whether `serpenoid play` would refuse a gait, and why; nothing moves.

It needs the gait and the robot file, and no robot: number of joints, angles and speeds within the limits of the robot
file, of its servos at the nominal voltage and of the body in the results, and whether the bus is fast enough. With
--port the robot is asked, too: are these its servos, healthy and fed, how narrow are limits in their own memory, how
far is the body from the gait's first row.

  serpenoid robot check RESULTS --robot problems/robots/snake10-robot.toml
  serpenoid robot check RESULTS --robot problems/robots/snake10-robot.toml --port auto
"""

SCAN = "Say which servos answer, at which baud rate; nothing moves."
OFF = "Switch off the torque of every servo of a robot file, whatever was going on."
REBOOT = "Clear the hardware errors of every servo of a robot file, after their cause is gone."
POWER = "Record the INA260 stream of a board as power.csv, without playing."


def configure(actions: Any) -> None:
    rates = ", ".join(map(str, SCAN_RATES))
    scan = actions.add_parser("scan", help="which servos answer, at which baud rate", description=SCAN)
    scan.add_argument("--port", default="auto", metavar="PORT", help="serial port (default auto)")
    scan.add_argument("--baud-rate", type=int, metavar="B", help=f"try this rate alone (default: {rates})")
    scan.set_defaults(do=_scan)
    check = actions.add_parser("check", help="would this gait be refused, and why", description=CHECK)
    add_table(check)
    add_robot(check, port="")
    check.set_defaults(do=_check)
    for name, do, text, about in (
        ("off", _off, "torque off on every servo", OFF),
        ("reboot", _reboot, "clear hardware errors", REBOOT),
    ):
        action = actions.add_parser(name, help=text, description=about)
        add_robot(action, port="auto")
        action.set_defaults(do=do)
    power = actions.add_parser("power", help="record an INA260 stream: power.csv", description=POWER)
    power.add_argument("--port", required=True, metavar="PORT", help="serial port of the streaming board")
    power.add_argument("--log", "--out", required=True, type=target, metavar="DIR", help="folder for power.csv")
    power.add_argument("--seconds", type=float, default=float("inf"), metavar="S", help="default: until Ctrl-C")
    power.set_defaults(do=_power)


def _scan(args: argparse.Namespace) -> int:
    port = resolve_port(args.port)
    rates = (args.baud_rate,) if args.baud_rate else SCAN_RATES
    total, colliding = 0, False
    for rate in rates:
        try:
            with open_bus(port, rate, {}) as bus:
                found, garbled = _print_found(bus, rate)
                total, colliding = total + found, colliding or garbled
        except RobotFault as fault:
            warn(fault)
    if colliding:
        warn(COLLISION_REMEDY)
    elif not total:
        tried = f"{port}: no servo answered at {', '.join(map(str, rates))} baud"
        warn(
            f"{tried}. Is the battery on and the cable in? New servos have 57600 baud and ID 1: connect one at a time."
        )
    return 0 if total and not colliding else 1


def _print_found(bus: Bus, rate: int) -> tuple[int, bool]:
    """How many servos answered, and whether some talked at once."""
    found = bus.scan()
    shared = set(found.repeated)
    for servo_id, (number, firmware) in found.servos.items():
        model = by_number(number)
        name, reading = f"model number {number}", "not a model that is known here: nothing was read of it"
        if model is not None:
            name = model.name
            try:
                reading = _reading(bus, servo_id)
            except PortLost:
                raise
            except RobotFault as fault:
                reading = str(fault)
                shared |= {servo_id} if bus.is_garbled(servo_id) else set()
        sys.stdout.write(f"ID {servo_id:3d}  {name}  firmware {firmware}  {rate} baud  {reading}\n")
    if found.garbled and not shared:
        shared = _who_is_garbled(bus, set(found.servos))
    for servo_id in sorted(shared):
        warn(f"ID {servo_id:3d}  {rate} baud  garbled: more than one servo has this ID")
    if found.garbled and not shared:
        warn(f"{found.garbled} bytes at {rate} baud were no whole answer: two servos with one ID, or noise on the line")
    return len(found.servos), found.collision or bool(shared)


def _reading(bus: Bus, servo_id: int) -> str:
    state = bus.read_states([servo_id])[servo_id]
    return f"{state.position} ticks, {state.voltage:.1f} V, {state.temperature} deg C"


def _who_is_garbled(bus: Bus, understood: set[int]) -> set[int]:
    """Ask every other ID by itself, twice where the first answer was garbled."""
    warn("something answered that could not be understood; asking every ID by itself (some seconds)")
    others = [servo_id for servo_id in range(LAST_ID + 1) if servo_id not in understood]
    return {servo_id for servo_id in others if bus.is_garbled(servo_id) and bus.is_garbled(servo_id)}


def _check(args: argparse.Namespace) -> int:
    robot = load_robot(args)
    table, refusals = checked_table(args, robot)
    how = f"at {robot.nominal_V:g} V (nominal; --port measures it)"
    if args.port and not refusals:
        refusals, how = _check_live(args, table, robot)
    if refusals:
        warn(f"refused {how}:", *refusals)
        return 1
    sys.stdout.write(
        f"{table.source}: {table.steps} steps x {counted(table.joints, 'joint')} may be played on {robot.name} {how}\n"
    )
    return 0


def _check_live(args: argparse.Namespace, table: JointTable, robot: Robot) -> tuple[list[Refusal], str]:
    """With the servos' own voltage and positions; torque stays as it is."""
    port = resolve_port(args.port)
    with open_bus(port, robot.bus.baud_rate, robot.by_id) as bus:
        try:
            refusals = identify(bus, robot)
            if refusals:
                return refusals, f"on {port}"
            refusals = inspect(bus, robot)
            robot, notes = narrower(bus, robot)
            warn(*notes)
            states = [bus.read_states(robot.ids)[servo_id] for servo_id in robot.ids]
        except RobotFault as fault:
            return [Refusal(port, str(fault), "the bus must answer", "Check power and cable.")], "on the bus"
    volts = min(state.voltage for state in states)
    refusals += check_table(table.angles, robot, cycle_duration(args, table, robot), volts, table.closed)
    present = np.array([state.position for state in states])
    return refusals + check_start(present, to_ticks(table.angles[0], robot), robot), f"at {volts:.1f} V (measured)"


def _off(args: argparse.Namespace) -> int:
    robot, port = load_robot(args), resolve_port(args.port)
    with open_bus(port, robot.bus.baud_rate, robot.by_id) as bus:
        try:
            silent = bus.torque_off(robot.ids)
        except RobotFault as fault:
            warn(fault)
            return 1
    if silent:
        warn(f"servos {', '.join(map(str, silent))} did not confirm torque off. CUT THE BATTERY if they hold.")
        return 1
    sys.stdout.write("torque is off on every servo, each confirmed it\n")
    return 0


def _reboot(args: argparse.Namespace) -> int:
    robot, port = load_robot(args), resolve_port(args.port)
    with open_bus(port, robot.bus.baud_rate, robot.by_id) as bus:
        for servo_id in robot.ids:
            try:
                bus.reboot(servo_id)
            except RobotFault as fault:
                warn(fault)
                return 1
    sys.stdout.write(f"{counted(len(robot.ids), 'servo')} rebooted; torque is off\n")
    return 0


def _power(args: argparse.Namespace) -> int:
    lines = record_power(resolve_port(args.port), args.log, args.seconds)
    sys.stdout.write(f"{lines} lines in {args.log / 'power.csv'}\n")
    return 0 if lines else 1
