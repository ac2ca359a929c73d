"""Write a gait for the robot.

RESULTS is a results folder or a joint-table CSV. Formats:
  csv      joint_table.csv, radians; joint_table.json: what `play` must know of it (a transient? limits, duration).
           Of a gait in space ([lift]), which the other formats do not know: yaw of every joint, then pitch
  ticks    ticks.csv, servo positions as --robot maps them
  openrb   an Arduino sketch for the OpenRB-150 that plays the gait without a computer (library Dynamixel2Arduino)
  ros2     JointTrajectory as MCAP and as YAML for joint_trajectory_controller

  serpenoid export RESULTS --format openrb --robot problems/robots/snake10-robot.toml --cycles 3 --pause 2 --out snake
  ros2 topic pub --once /joint_trajectory_controller/joint_trajectory trajectory_msgs/msg/JointTrajectory \\
      "$(cat DIR/joint_trajectory.yaml)"

--out gait.csv writes that file (csv, beside it gait.json; ticks), any other --out is a folder. Formats for a particular
robot are checked as `serpenoid robot check` does; nothing is written if a check refuses.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from serpenoid.cli.claim import place
from serpenoid.cli.options import check_writable
from serpenoid.cli.robot_arguments import (
    add_robot,
    add_table,
    add_widen,
    body_refusals,
    checked_table,
    cycle_duration,
    load_robot,
    planned,
    told_duration,
    warn,
)
from serpenoid.errors import InputError
from serpenoid.files.writing import write_csv, write_json, write_text
from serpenoid.robot import ros
from serpenoid.robot.checks import Refusal, check_finite
from serpenoid.robot.description import Robot
from serpenoid.robot.firmware import sketch
from serpenoid.robot.plan import Plan, check_repetition
from serpenoid.robot.stated import own_record
from serpenoid.robot.table import JointTable, read_table, write_table

SKETCH = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,62}")
ENDINGS = (".csv", ".ino", ".mcap", ".yaml")  # of a file, where a folder may be meant
TABLES = ("csv", "ticks")  # formats that tell rows, and not to every program how they are played
Exporter = Callable[[argparse.Namespace, JointTable, Robot | None, Path], None]


def configure(parser: argparse.ArgumentParser) -> None:
    add_table(parser)
    parser.add_argument("--format", required=True, choices=list(EXPORTERS), help="see above")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for the files, or a file .csv")
    parser.add_argument("--force", action="store_true", help="move other files of their names aside")
    add_robot(parser, required=False)
    parser.add_argument("--cycles", type=int, default=1, metavar="N", help="openrb, ros2: cycles to play (default 1)")
    parser.add_argument("--pause", type=float, default=0.0, metavar="S", help="openrb, ros2: rest after each cycle [s]")
    add_widen(parser)
    parser.add_argument("--power-stream", action="store_true", help="openrb: stream INA260 readings over USB")


def run(args: argparse.Namespace) -> int:
    table, robot, refusals = _load(args)
    if refusals:
        warn("refused, nothing was written:", *refusals)
        return 1
    file = _file(args)
    folder = args.out if file is None else args.out.parent
    check_writable(folder)
    with tempfile.TemporaryDirectory() as made:
        EXPORTERS[args.format](args, table, robot, Path(made))
        if file is not None:
            for path in sorted(Path(made).iterdir()):
                path.rename(path.with_name(file if path.suffix == ".csv" else own_record(Path(file)).name))
        paths = place(args, Path(made), folder)
    sys.stdout.writelines(f"{path}\n" for path in paths)
    if not table.closed and args.format in TABLES:
        warn(f"a transient: its {table.steps + 1} rows are {table.steps} steps to be played once; hold the last row")
    return 0


def _file(args: argparse.Namespace) -> str | None:
    """The name of the one file that --out asks for; None: it is a folder."""
    ending = args.out.suffix.lower()
    if args.out.is_dir() or ending not in ENDINGS:
        return None
    if ending != ".csv" or args.format not in TABLES:
        raise InputError(f"--out {args.out}: --format {args.format} writes into a folder: name one without `{ending}`.")
    return str(args.out.name)


def _load(args: argparse.Namespace) -> tuple[JointTable, Robot | None, list[Refusal]]:
    if args.robot is not None:
        robot = load_robot(args)
        table, refusals = checked_table(args, robot)
        return table, robot, refusals
    table = read_table(args.results, any_table=args.format == "csv")
    return table, None, check_finite(table.angles) or body_refusals(args, table, told_duration(args, table))


def _csv(args: argparse.Namespace, table: JointTable, _: Robot | None, folder: Path) -> None:
    file = folder / "joint_table.csv"
    write_table(file, table.angles, table.in_space)
    stated = table.stated.model_copy(update={"cycle_duration_s": told_duration(args, table)})
    write_json(own_record(file), stated.model_dump(mode="json"))


def _ticks(args: argparse.Namespace, table: JointTable, robot: Robot | None, folder: Path) -> None:
    plan = _plan(args, table, robot)
    header = [f"servo_{servo_id}" for servo_id in plan.robot.ids]
    write_csv(folder / "ticks.csv", header, plan.ticks.tolist())


def _openrb(args: argparse.Namespace, table: JointTable, robot: Robot | None, folder: Path) -> None:
    """The Arduino tools want a sketch in a folder of its own name, and refuse others than SKETCH."""
    name = args.out.resolve().name
    if SKETCH.fullmatch(name) is None:
        raise InputError(
            f"--out {args.out}: a sketch is named as its folder, and the Arduino tools want letters, digits, `_`, `.` "
            "and `-`, at most 63, beginning with a letter or digit."
        )
    write_text(folder / f"{name}.ino", sketch(_plan(args, table, robot), args.power_stream))


def _ros2(args: argparse.Namespace, table: JointTable, robot: Robot | None, folder: Path) -> None:
    duration = cycle_duration(args, table, robot)
    check_repetition(args.cycles, args.pause)
    trajectory = ros.make_trajectory(table.angles, duration, args.cycles, args.pause, table.closed)
    ros.write_mcap(folder / "joint_trajectory.mcap", trajectory)
    ros.write_yaml(folder / "joint_trajectory.yaml", trajectory)


def _plan(args: argparse.Namespace, table: JointTable, robot: Robot | None) -> Plan:
    if robot is None:
        raise InputError(f"--format {args.format} needs --robot FILE: it maps joints to servos.")
    return planned(args, table, robot)


EXPORTERS: dict[str, Exporter] = {"csv": _csv, "ticks": _ticks, "openrb": _openrb, "ros2": _ros2}
