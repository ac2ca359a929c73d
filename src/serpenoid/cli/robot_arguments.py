"""Arguments that `play`, `export` and `robot` share."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TextIO

from serpenoid.body import LONGEST_CYCLE_S
from serpenoid.errors import InputError
from serpenoid.files.schema import load
from serpenoid.robot.checks import Refusal, check_body, check_given, check_repetition, check_table, kept_by_one_cycle
from serpenoid.robot.description import Robot
from serpenoid.robot.plan import Plan, make_plan
from serpenoid.robot.stated import SHORTEST_CYCLE_S
from serpenoid.robot.table import JointTable, read_table


def add_table(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("results", type=Path, metavar="RESULTS", help="results folder, or a joint-table CSV")
    parser.add_argument(
        "--cycle-duration",
        type=float,
        metavar="S",
        help="time of one cycle [s] (default: what the results say, else the robot file)",
    )
    parser.add_argument(
        "--no-joint-limits",
        action="store_true",
        help="do not hold the body's joint and speed limits that the results state; the robot file's hold always",
    )


def add_robot(parser: argparse.ArgumentParser, port: str | None = None, required: bool = True) -> None:
    parser.add_argument("--robot", type=Path, metavar="FILE", required=required, help="robot file (TOML)")
    if port is not None:
        parser.add_argument("--port", default=port, metavar="PORT", help=f"serial port (default {port or 'none'})")


def load_robot(args: argparse.Namespace) -> Robot:
    return load(Robot, args.robot)


def told_duration(args: argparse.Namespace, table: JointTable) -> float | None:
    """--cycle-duration, else the results' own [s]; None: nobody says."""
    given = args.cycle_duration
    if given is not None and not SHORTEST_CYCLE_S <= given <= LONGEST_CYCLE_S:
        least = f"{SHORTEST_CYCLE_S:g} is the least"
        raise InputError(f"--cycle-duration must be above 0 and at most 600 seconds, got {given}: {least}.")
    return given or table.stated.cycle_duration_s


def cycle_duration(args: argparse.Namespace, table: JointTable, robot: Robot | None) -> float:
    """The same, else the robot file's [s]."""
    chosen = told_duration(args, table) or (robot.motion.cycle_duration_s if robot else None)
    if chosen is None:
        raise InputError("The results do not say how long a cycle lasts. Give --cycle-duration S or --robot FILE.")
    return chosen


def planned(args: argparse.Namespace, table: JointTable, robot: Robot) -> Plan:
    """What servos are told, row by row."""
    return make_plan(
        table.angles,
        robot,
        cycle_duration(args, table, robot),
        args.cycles,
        args.pause,
        args.widen_limits,
        table.closed,
    )


def checked_table(args: argparse.Namespace, robot: Robot) -> tuple[JointTable, list[Refusal]]:
    """The table and what speaks against it, at the robot's nominal voltage."""
    table = read_table(args.results)
    duration = cycle_duration(args, table, robot)
    if malformed := check_given(table.angles, robot):
        return table, malformed
    refusals = check_table(table.angles, robot, duration, robot.nominal_V, table.closed)
    return table, kept_by_one_cycle(refusals + body_refusals(args, table, duration))


def body_refusals(args: argparse.Namespace, table: JointTable, duration: float | None) -> list[Refusal]:
    """What the results' own body forbids; limits that do not hold are named on standard error."""
    stated = table.stated
    off = stated.switched_off
    if off:
        warn(f"{' and '.join(off)} switched off in the problem file: not held")
    warn(*table.doubts, *stated.doubts)
    repeated = check_repetition(table.angles, stated, getattr(args, "cycles", 1))
    if args.no_joint_limits:
        warn("--no-joint-limits: the limits of the results' body are not held")
        return repeated
    return repeated + check_body(table.angles, stated, duration, table.columns)


def add_widen(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--widen-limits",
        action="store_true",
        help="write the robot file's limits over narrower ones in the servos' own memory (default: the narrower hold)",
    )


def warn(*lines: object) -> None:
    tell(sys.stderr, *lines)


def tell(stream: TextIO | None, *lines: object) -> None:
    """Write lines; where the stream is closed or its disk full, on standard error: what a robot does must be said."""
    for target in (stream, sys.stderr):
        try:
            if target is not None:
                target.writelines(f"{line}\n" for line in lines)
                target.flush()
                return
        except (OSError, ValueError):  # ValueError: closed
            continue


def sentence(text: str) -> str:
    """The text with one mark at its end."""
    return text if text.endswith((".", "?", "!")) else f"{text}."
