"""Write a gait for the robot.

RESULTS is a results folder or a joint-table CSV. Formats:
  csv      joint_table.csv, radians; joint_table.json: what `play` must know of it (a transient? limits, duration).
           Of a gait in space ([lift]), which the other formats do not know: yaw of every joint, then pitch
  angles   angles.csv for a controller of your own: --rate rows a second (default: the table's), --angle-unit, --signs,
           --zeros; joint_table.csv: the same rows as `campaign add` wants them, radians
  ticks    ticks.csv, servo positions as --robot maps them
  openrb   an Arduino sketch for the OpenRB-150 that plays the gait without a computer (library Dynamixel2Arduino)
  ros2     JointTrajectory as MCAP and as YAML for joint_trajectory_controller

  serpenoid export RESULTS --format angles --cycle-duration 2 --rate 50 --signs=-1 --zeros 90 --out gait
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
from serpenoid.cli.target import target
from serpenoid.errors import InputError
from serpenoid.files.writing import write_csv, write_json, write_text
from serpenoid.robot import ros
from serpenoid.robot.angles import UNITS, commands, of_each, paced, signs_of
from serpenoid.robot.checks import Refusal, check_finite
from serpenoid.robot.description import Robot
from serpenoid.robot.firmware import sketch
from serpenoid.robot.plan import Plan, check_repetition
from serpenoid.robot.stated import own_record
from serpenoid.robot.table import JointTable, read_table, write_table

SKETCH = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,62}")
ENDINGS = (".csv", ".ino", ".mcap", ".yaml")  # of a file, where a folder may be meant
ALONE = ("csv", "ticks")  # formats of one table, which may be a file
TABLES = (*ALONE, "angles")  # formats that tell rows, and not to every program how they are played
Exporter = Callable[[argparse.Namespace, JointTable, Robot | None, Path], None]


def configure(parser: argparse.ArgumentParser) -> None:
    add_table(parser)
    parser.add_argument("--format", required=True, choices=list(EXPORTERS), help="see above")
    parser.add_argument("--out", type=target, required=True, metavar="DIR", help="folder for the files, or a file .csv")
    parser.add_argument("--force", action="store_true", help="move other files of their names aside")
    add_robot(parser, required=False)
    _add_angles(parser)
    parser.add_argument("--cycles", type=int, default=1, metavar="N", help="openrb, ros2: cycles to play (default 1)")
    parser.add_argument("--pause", type=float, default=0.0, metavar="S", help="openrb, ros2: rest after each cycle [s]")
    add_widen(parser)
    parser.add_argument("--power-stream", action="store_true", help="openrb: stream INA260 readings over USB")


def _add_angles(parser: argparse.ArgumentParser) -> None:
    own = parser.add_argument_group("angles")
    own.add_argument("--rate", type=float, metavar="HZ", help="rows a second (default: as many as the table has)")
    own.add_argument("--angle-unit", choices=UNITS, help=f"of the angles (default {UNITS[0]})")
    signs = "1 or -1, tail to head with commas or one for all (as --signs=-1); 1: counter-clockwise seen from above"
    own.add_argument("--signs", metavar="N,N", help=signs)
    zeros = "what the controller calls straight, in that unit (90 of most hobby servos), likewise (default 0)"
    own.add_argument("--zeros", metavar="A,A", help=zeros)


def run(args: argparse.Namespace) -> int:
    given = [name for name in ("rate", "angle-unit", "signs", "zeros") if getattr(args, name.replace("-", "_"))]
    if given and args.format != "angles":
        raise InputError(f"--{given[0]}: is for --format angles, got {args.format}. Leave it out.")
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
    if ending != ".csv" or args.format not in ALONE:
        raise InputError(f"--out {args.out}: --format {args.format} writes into a folder: name one without `{ending}`.")
    return str(args.out.name)


def _load(args: argparse.Namespace) -> tuple[JointTable, Robot | None, list[Refusal]]:
    if args.robot is not None:
        robot = load_robot(args)
        table, refusals = checked_table(args, robot)
        return table, robot, refusals
    table = read_table(args.results, any_table=args.format == "csv")
    return table, None, check_finite(table.angles) or body_refusals(args, table, told_duration(args, table))


def _angles(args: argparse.Namespace, table: JointTable, robot: Robot | None, folder: Path) -> None:
    rows, stated = table.angles, table.stated.model_copy(update={"cycle_duration_s": told_duration(args, table)})
    if args.rate is not None:
        rows = paced(rows, table.closed, cycle_duration(args, table, robot), args.rate)
    unit, joints = args.angle_unit or UNITS[0], rows.shape[1]
    told = commands(rows, unit, signs_of(args.signs or "1", joints), of_each(args.zeros or "0", joints, "--zeros"))
    write_csv(folder / "angles.csv", [f"{name}_{unit}" for name in table.columns], told.tolist())
    write_table(folder / "joint_table.csv", rows)
    write_json(own_record(folder / "joint_table.csv"), stated.model_dump(mode="json"))


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


EXPORTERS: dict[str, Exporter] = {"csv": _csv, "angles": _angles, "ticks": _ticks, "openrb": _openrb, "ros2": _ros2}
