"""Take a recorded trial into a campaign folder.

    serpenoid new campaign my-campaign --problem my-robot.toml
    serpenoid play RESULTS --robot servos.toml --cycles 3 --pause 2 --log trials/gait01-1
    serpenoid campaign add my-campaign trials/gait01-1 ~/Motive/take-17.csv
    serpenoid measure my-campaign

    serpenoid export RESULTS --format angles --signs=-1 --out gait    # for a controller of your own
    serpenoid campaign add my-campaign gait film-1.csv --cycles 3 --pause 1

    serpenoid new campaign my-worm --film worm-1.csv --format sleap --frames-per-second 30
    serpenoid campaign add my-worm worm-2.csv                   # of an animal there is no log

`add` copies what was played and the cameras' file into the campaign and appends a [[trial]] section; a trial with the
joint table of an earlier one becomes its repeat. Nothing is changed where a file cannot be read, or is not what the
campaign says of its markers and columns.
"""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path

from serpenoid.cli import campaigns, options


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `campaign`."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    add = actions.add_parser("add", help="a log of `play` and a motion file, or an animal's film", description=__doc__)
    add.add_argument("campaign", type=Path, metavar="CAMPAIGN", help="campaign folder")
    log_help = (
        "folder that `serpenoid play --log` wrote, or the joint table (or its folder) that another controller played; "
    )
    add.add_argument("played", type=Path, nargs="?", metavar="LOG", help=f"{log_help}of an animal left out")
    add.add_argument("motion", type=Path, metavar="MOTION", help="the cameras' file of that trial")
    add.add_argument("--name", metavar="NAME", help="of the trial (default: the log folder's, else the film's)")
    add.add_argument(
        "--gait", metavar="LABEL", help="default: that of a trial with the same joint table, else the name"
    )
    format_help = f"of this motion file, if not the campaign's: {campaigns.formats()}"
    add.add_argument("--format", metavar="FORMAT", help=format_help)
    add.add_argument("--individual", metavar="NAME", help="whose points, where the film shows several animals")
    add.add_argument("--from", dest="from_s", type=float, metavar="S", help="use the motion file from here")
    add.add_argument("--to", dest="to_s", type=float, metavar="S", help="... to here")
    add.add_argument("--anyway", action="store_true", help="also a trial that was not played as asked")
    other = add.add_argument_group("of a joint table that another controller played")
    other.add_argument("--cycles", type=options.positive, metavar="N", help="cycles played")
    other.add_argument("--pause", type=float, metavar="S", help="rest after each cycle [s] (default 0)")
    other.add_argument(
        "--cycle-duration", type=float, metavar="S", help="time of one cycle [s] (default: its results')"
    )
    other.add_argument("--servo-log", type=Path, metavar="FILE", help="what its servos read, if they do ([servo_log])")
    options.add_output(add)


def run(args: argparse.Namespace) -> int:
    """Add, say what to do next."""
    from serpenoid.scaffold.add import NewTrial, Schedule, add_trial

    given = ((key, getattr(args, key)) for key in ("format", "individual", "from_s", "to_s"))
    keys = tuple((key, value) for key, value in given if value is not None)
    schedule = Schedule(args.cycles, args.pause or 0.0, args.cycle_duration, args.servo_log)
    new = NewTrial(args.played, args.motion, args.name, args.gait, keys, args.anyway, schedule)
    name = add_trial(args.campaign, new)
    text = f"trial `{name}` added to {args.campaign}. Next: serpenoid measure {shlex.quote(str(args.campaign))}"
    options.report(args, {"campaign": str(args.campaign), "trial": name}, [text])
    return 0
