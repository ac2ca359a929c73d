"""The virtual laboratory: play gaits on the simulated robot and write a campaign folder.

    serpenoid arena run PROTOCOL.toml --out campaigns/mats
    serpenoid arena use results/mats/diagnosis-1a2b3c4d PROTOCOL.toml    # what is the diagnosis worth?

`use` finds the optimal gait under the diagnosis' baseline and under its extended model, and plays both on the robot of
the protocol, with the changes that are in it. Run the same command again to continue after an interruption.
docs/arena.md describes protocol and physics.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from serpenoid.cli import options
from serpenoid.cli.claim import claim, content_of, move_aside, sign
from serpenoid.cli.log import log, settle
from serpenoid.cli.target import target
from serpenoid.wording import counted

RUN = """Play every trial of a protocol in the virtual laboratory and write them as a campaign folder.

    serpenoid arena run problems/protocols/two-gaits.toml --out results/two-gaits
    serpenoid measure results/two-gaits && serpenoid compare results/two-gaits

A protocol names joint tables, repeats and headings; `problem = "mine.toml"` plays the body of a problem file instead of
the paper's ten-servo snake: its links, joints and masses, with wheels scaled to it ([robot] overrides each number).
The folder receives campaign.toml, gaits/ and one folder per trial: motion.csv (as Motive exports it), servo.csv,
power.csv. A trial takes some seconds. Ctrl-C keeps whole trials; the same command goes on.
`serpenoid new protocol` writes a protocol to begin with; `serpenoid schema protocol` lists every key."""

USE = """What a diagnosis is worth: the optimal gaits before and after its extension, both played on one robot.

    serpenoid arena use results/mats/diagnosis-1a2b3c4d PROTOCOL.toml --problem problems/snake10.toml"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `arena`."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    played = actions.add_parser("run", help="play a protocol and write a campaign", description=RUN)
    played.add_argument("protocol", metavar="PROTOCOL.toml", type=Path, help="what is played, on which robot and floor")
    played.add_argument("--out", metavar="FOLDER", type=target, help="campaign folder (default: results/<protocol>)")
    played.add_argument("--truth", metavar="FOLDER", type=target, help="also write the noise-free motion, elsewhere")
    played.add_argument("--force", action="store_true", help="move what else is in the folder aside")
    used = actions.add_parser("use", help="play a diagnosis' optimal gaits, before and after", description=USE)
    used.add_argument("diagnosis", metavar="DIAGNOSIS", type=Path, help="folder that `diagnose` wrote")
    used.add_argument("protocol", metavar="PROTOCOL.toml", type=Path, help="robot and floor to play them on")
    used.add_argument("--problem", metavar="FILE", type=Path, help="whose gaits (default: the snake robot's)")
    used.add_argument("--trials", type=options.positive, default=6, metavar="N", help="of each gait (default 6)")
    used.add_argument("--cycles", type=options.positive, default=1, metavar="N", help="a trial (default 1)")
    used.add_argument("--out", metavar="FOLDER", type=target, help="default: DIAGNOSIS/in-use")
    used.add_argument("--force", action="store_true", help="move another answer in the folder aside")
    for action in (played, used):
        options.add_workers(action, "trials", os.cpu_count() or 1)
        options.add_output(action)
    options.add_open(used)


def run(args: argparse.Namespace) -> int:
    """Play, write, say where."""
    return _run(args) if args.action == "run" else _use(args)


def _run(args: argparse.Namespace) -> int:
    from serpenoid.arena.campaign import another, run_campaign
    from serpenoid.arena.protocol import load_protocol
    from serpenoid.arena.robot import too_weak
    from serpenoid.arena.trial import plans

    protocol, tables = load_protocol(args.protocol)
    folder = args.out or Path("results") / args.protocol.stem
    for place in (folder, *([args.truth] if args.truth else [])):
        options.check_writable(place)
    settle([folder])
    if args.force and folder.is_dir() and another(protocol, tables, folder):
        move_aside(folder)
    weak = too_weak(protocol.robot)
    if weak:
        log.warning("%s", weak)
    total = len(plans(protocol))
    with options.progress_bar(args, "trials", total) as advance:
        run_campaign(protocol, tables, folder, workers=options.workers(args), truth=args.truth, report=advance)
    record = {"campaign": str(folder / "campaign.toml"), "trials": total, "remarks": [weak] if weak else []}
    options.report(args, record, [f"{counted(total, 'trial')} described in {folder / 'campaign.toml'}"])
    return 0


def _use(args: argparse.Namespace) -> int:
    from serpenoid.arena.protocol import load_protocol
    from serpenoid.errors import InputError
    from serpenoid.files.writing import examples, write_json
    from serpenoid.problem import load
    from serpenoid.studies import in_use

    if args.trials < 2:
        raise InputError("--trials: one trial has no spread; give 2 or more.")
    robot, _ = load_protocol(args.protocol)
    problem = args.problem or examples() / "snake10.toml"
    protocol = in_use.protocol_of(robot, load(problem), args.trials, args.cycles)
    tasks = in_use.tasks_of(problem, args.diagnosis)
    folder = args.out or args.diagnosis / "in-use"
    settle([folder])
    models = content_of(*(args.diagnosis / name for name in in_use.MODELS.values()))
    claim(args, folder, models, load(problem).hash, protocol.model_dump(mode="json"))
    sign(args)
    with options.progress_bar(args, "gaits", len(in_use.MODELS)) as advance:
        gaits = in_use.optimal_gaits(tasks, advance)
        advance(len(gaits), "")
    with options.progress_bar(args, "trials", args.trials * len(gaits)) as advance:
        found = in_use.play(folder, protocol, gaits, options.workers(args), advance)
    record = in_use.record_of(gaits, found)
    write_json(folder / "in-use.json", record)
    options.report(args, record, [*in_use.lines(record), f"written to {folder}"], folder)
    return 0
