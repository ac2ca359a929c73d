"""The virtual laboratory: play a protocol's gaits on the simulated robot and write a campaign folder.

    serpenoid arena run PROTOCOL.toml --out campaigns/mats

Run the same command again to continue after an interruption. docs/arena.md describes protocol and physics.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from serpenoid.cli import options


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `arena`."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    played = actions.add_parser("run", help="play a protocol and write a campaign")
    played.add_argument("protocol", metavar="PROTOCOL.toml", type=Path)
    played.add_argument("--out", metavar="FOLDER", type=Path, help="campaign folder (default: results/<protocol>)")
    played.add_argument("--jobs", "-j", type=int, default=os.cpu_count() or 1, metavar="N", help="trials at a time")
    played.add_argument("--truth", metavar="FOLDER", type=Path, help="also write the noise-free motion, elsewhere")
    options.add_output(played, out=False)


def run(args: argparse.Namespace) -> int:
    """Play, write, say where."""
    from serpenoid.arena.campaign import run_campaign
    from serpenoid.arena.protocol import load_protocol
    from serpenoid.arena.trial import plans

    protocol, tables = load_protocol(args.protocol)
    folder = args.out or Path("results") / args.protocol.stem
    total = len(plans(protocol))
    with options.progress_bar(args, "trials", total) as advance:
        run_campaign(protocol, tables, folder, jobs=max(1, args.jobs), truth=args.truth, report=advance)
    record = {"campaign": str(folder / "campaign.toml"), "trials": total}
    options.report(args, record, [f"{total} trials described in {folder / 'campaign.toml'}"])
    return 0
