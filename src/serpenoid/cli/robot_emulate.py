"""`serpenoid robot emulate`: servos on a pseudo-terminal, with faults to rehearse.

Those of --robot, else ten XL430-W250-T; --model NAME makes all of them servos of one model.

Prints the port and serves until Ctrl-C; then says what became of the servos. In another terminal:

  serpenoid robot scan --port PORT
  serpenoid play RESULTS --robot problems/robots/snake10-robot.toml --port PORT

With --arena the servos are built into the robot of the virtual arena (docs/arena.md) and drive it over its floor.

Faults begin a number of seconds after torque is first switched on: --fault KIND[:SERVO]@SECONDS[=VALUE]
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from serpenoid.cli.target import target
from serpenoid.errors import InputError
from serpenoid.files.alone import LOCK, alone
from serpenoid.files.schema import load
from serpenoid.files.writing import write_json
from serpenoid.robot.description import Robot
from serpenoid.robot.emulator.chain import Chain
from serpenoid.robot.emulator.faults import KINDS, Fault, parse_fault
from serpenoid.robot.emulator.server import PtyServer
from serpenoid.robot.emulator.servo import EmulatedServo
from serpenoid.robot.models import DEFAULT, ServoModel, models
from serpenoid.robot.timing import before_other_programs
from serpenoid.wording import counted

if TYPE_CHECKING:
    from serpenoid.arena.bus import Ground


PSEUDO_TERMINALS = "/dev/pts/", "/dev/ttys"  # of Linux, of macOS


def configure(actions: Any) -> None:
    faults = "\n".join(f"  {kind + (':SERVO' if needs else ''):<16} {text}" for kind, (needs, _, text) in KINDS.items())
    parser = actions.add_parser(
        "emulate",
        help="emulated servos on a port of their own",
        description=__doc__,
        epilog=f"fault kinds:\n{faults}",
    )
    parser.add_argument("--robot", type=Path, metavar="FILE", help="IDs, models, baud rate and zeros of this file")
    parser.add_argument("--model", choices=models(), metavar="NAME", help=_models_in_words())
    parser.add_argument("--baud-rate", type=int, metavar="B", help="default: the robot file's, else 1000000")
    parser.add_argument("--ids", metavar="N,N", help="other IDs, tail first; twice the same: two servos that collide")
    parser.add_argument("--link", type=target, metavar="PATH", help="symbolic link to the port, by a name that stays")
    parser.add_argument("--fault", action="append", default=[], metavar="FAULT", help="a fault, see below; repeatable")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of the random faults (default 0)")
    parser.add_argument(
        "--report", type=target, metavar="FILE", help="write what became of the servos to this JSON file"
    )
    parser.add_argument("--arena", action="store_true", help="the servos move the robot of the virtual arena")
    parser.add_argument("--problem", type=Path, metavar="FILE", help="with --arena: whose body (the paper's snake)")
    parser.add_argument(
        "--motion", type=target, metavar="FILE", help="with --arena: where it went, as a tidy motion CSV"
    )
    parser.set_defaults(do=run)


def run(args: argparse.Namespace) -> int:
    if args.link is not None:
        _hold(args, args.link)
    baud_rate, servos = _servos(args)
    ids = {servo.id for servo in servos}
    chain = Chain(servos, baud_rate, [_fault(text, ids) for text in args.fault], args.seed)
    ground = _ground(args, servos)
    chain.ground = ground
    server = PtyServer(chain, baud_rate, args.link)
    stopping: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda received, _: stopping.append(received))
    sys.stdout.write(f"{server.port}\n")
    sys.stdout.flush()
    names = ", ".join(dict.fromkeys(servo.model.name for servo in servos))
    emulated = f"{counted(len(servos), 'emulated servo')} ({names})"
    sys.stderr.write(f"{emulated} at {baud_rate} baud on {server.port}; Ctrl-C ends\n")
    with before_other_programs():
        server.serve(lambda: bool(stopping))
    report = server.report()
    server.close()
    if ground is not None:
        ground.close(args.motion)
    if args.report is not None:
        write_json(args.report, report)
    sys.stderr.write(_in_words(report))
    return 0


def _hold(args: argparse.Namespace, link: Path) -> None:
    """Refuse a link that cannot be, or that another emulator serves: it would be taken from it without a word."""
    if not link.parent.is_dir():
        raise InputError(f"--link {link}: there is no folder {link.parent}. Make it, or name another place.")
    if link.exists() and not link.is_symlink():
        raise InputError(f"--link {link}: a file is already there.")
    lock = f".{link.name}{LOCK}"
    if link.is_symlink() and not ((link.parent / lock).exists() or _leads_nowhere(link)):
        raise InputError(
            f"--link {link}: a link to {os.readlink(link)} is already there, which no emulator made. Remove it, or "
            "name another place."
        )
    said = f"--link {link}: another `robot emulate` serves this port. Name another link, or wait for its end."
    args.held.enter_context(alone(link.parent, said, lock=lock))


def _leads_nowhere(link: Path) -> bool:
    """Whether a link led to a terminal that is not there any more, as an emulator's that was killed."""
    return not link.exists() and os.readlink(link).startswith(PSEUDO_TERMINALS)


def _servos(args: argparse.Namespace) -> tuple[int, list[EmulatedServo]]:
    robot = load(Robot, args.robot) if args.robot else None
    baud_rate = args.baud_rate or (robot.bus.baud_rate if robot else 1000000)
    zeros = [joint.zero_ticks for joint in robot.joint] if robot else [2048] * 10
    ids = robot.ids if robot else list(range(1, 11))
    kinds = robot.servos if robot else [models()[DEFAULT]] * 10
    if args.ids is not None:
        ids = _ids(args.ids, len(ids))
    if args.model is not None:
        kinds = [models()[args.model]] * len(ids)
    places = zip(kinds, ids, zeros, strict=True)
    servos = [EmulatedServo(kind, servo_id, _code(kind, baud_rate), float(zero)) for kind, servo_id, zero in places]
    return baud_rate, servos


def _code(servo: ServoModel, baud_rate: int) -> int:
    """The value of Baud Rate (8)."""
    codes = {rate: code for code, rate in servo.baud_rates.items()}
    if baud_rate not in codes:
        rates = ", ".join(map(str, codes))
        raise InputError(f"--baud-rate must be one of {rates} for {servo.name} servos, got {baud_rate}.")
    return codes[baud_rate]


def _models_in_words() -> str:
    return f"all servos are of this model, whatever --robot says (without either {DEFAULT}): {', '.join(models())}"


def _fault(text: str, ids: set[int]) -> Fault:
    fault = parse_fault(text)
    if fault.servo is not None and fault.servo not in ids:
        raise InputError(f"--fault {text}: no emulated servo has this ID; there are {sorted(ids)}.")
    return fault


def _ids(text: str, count: int) -> list[int]:
    ids = [int(part) if part.strip().isdecimal() else -1 for part in text.split(",")]
    if len(ids) != count or not all(0 <= servo_id <= 252 for servo_id in ids):
        raise InputError(f"--ids must be {count} numbers from 0 to 252, one for each servo, got {text}.")
    return ids


def _ground(args: argparse.Namespace, servos: list[EmulatedServo]) -> Ground | None:
    if args.motion is not None and not args.arena:
        raise InputError("--motion: only the arena's robot goes anywhere. Add --arena.")
    if args.problem is not None and not args.arena:
        raise InputError("--problem: only the arena's robot has a body. Add --arena.")
    if not args.arena:
        return None
    if args.robot is None:
        raise InputError("--arena needs --robot FILE: it says which servo moves which joint.")
    from serpenoid.arena.bus import Ground
    from serpenoid.arena.robot import Robot as ArenaRobot
    from serpenoid.arena.robot import robot_of
    from serpenoid.problem import load as load_problem

    given = {"profile_s": 0.0}  # the emulated servos walk their profiles themselves
    body = {} if args.problem is None else robot_of(load_problem(args.problem).body)
    return Ground(servos, load(Robot, args.robot).joint, ArenaRobot.model_validate(given | body))


def _in_words(report: dict[str, Any]) -> str:
    servos = report["servos"]
    on = [servo["id"] for servo in servos if servo["torque"]]
    moved = {servo["id"]: [round(servo["lowest_ticks"]), round(servo["highest_ticks"])] for servo in servos}
    torque = f"torque still ON: servos {on}" if on else "torque is off on every servo"
    counts = f"{report['instructions']} instructions, {report['rejected']} rejected"
    return f"\n{torque}; {counts}\nranges [ticks]: {json.dumps(moved)}\n"
