"""The virtual laboratory: play a protocol's gaits on the simulated robot and write a campaign folder.

    serpenoid arena run PROTOCOL.toml --out campaigns/mats

Run the same command again to continue after an interruption. docs/arena.md describes protocol and physics.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn


def configure(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    run_parser = actions.add_parser("run", help="play a protocol and write a campaign")
    run_parser.add_argument("protocol", metavar="PROTOCOL.toml", type=Path)
    run_parser.add_argument("--out", metavar="FOLDER", type=Path, help="campaign folder (default: results/<protocol>)")
    run_parser.add_argument("--jobs", "-j", type=int, default=os.cpu_count() or 1, help="trials at a time")
    run_parser.add_argument("--truth", metavar="FOLDER", type=Path, help="also write the noise-free motion, elsewhere")


def run(args: argparse.Namespace) -> int:
    from serpenoid.arena.campaign import run_campaign
    from serpenoid.arena.protocol import load_protocol

    protocol, tables = load_protocol(args.protocol)
    folder = args.out or Path("results") / args.protocol.stem
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    console = Console(stderr=True)
    with Progress(*columns, console=console) as progress:
        task = progress.add_task("trials", total=None)
        run_campaign(
            protocol,
            tables,
            folder,
            jobs=max(1, args.jobs),
            truth=args.truth,
            report=lambda finished, total, name: progress.update(task, completed=finished, total=total),
        )
    Console().print(f"{folder / 'campaign.toml'}: written.", highlight=False, soft_wrap=True)
    return 0
