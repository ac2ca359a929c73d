"""Arguments that `play`, `export` and `robot` share."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from serpenoid.errors import InputError
from serpenoid.robot.checks import Refusal, check_table
from serpenoid.robot.description import Robot
from serpenoid.robot.table import JointTable, read_table
from serpenoid.schema import load


def add_table(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("results", type=Path, metavar="RESULTS", help="results folder, or a joint-table CSV")
    parser.add_argument(
        "--cycle-duration",
        type=float,
        metavar="S",
        help="time of one cycle [s] (default: what the results say, else the robot file)",
    )


def add_robot(parser: argparse.ArgumentParser, port: str | None = None, required: bool = True) -> None:
    parser.add_argument("--robot", type=Path, metavar="FILE", required=required, help="robot file (TOML)")
    if port is not None:
        parser.add_argument("--port", default=port, metavar="PORT", help=f"serial port (default {port or 'none'})")


def load_robot(args: argparse.Namespace) -> Robot:
    return load(Robot, args.robot)


def cycle_duration(args: argparse.Namespace, table: JointTable, robot: Robot | None) -> float:
    """--cycle-duration, else the results' own, else the robot file's [s]."""
    given = args.cycle_duration
    if given is not None and not 0 < given <= 600:
        raise InputError(f"--cycle-duration must be above 0 and at most 600 seconds, got {given}.")
    chosen = given or table.cycle_duration_s or (robot.motion.cycle_duration_s if robot else None)
    if chosen is None:
        raise InputError("The results do not say how long a cycle lasts. Give --cycle-duration S or --robot FILE.")
    return chosen


def checked_table(args: argparse.Namespace, robot: Robot) -> tuple[JointTable, list[Refusal]]:
    """The table and what speaks against it, at the robot's nominal voltage."""
    table = read_table(args.results)
    duration = cycle_duration(args, table, robot)
    return table, check_table(table.angles, robot, duration, robot.voltage.nominal_V)


def warn(*lines: object) -> None:
    sys.stderr.writelines(f"{line}\n" for line in lines)
