"""All results in and below some folders as one CSV: a line a run, of a campaign a line a trial.

    serpenoid table results --out runs.csv
    serpenoid table results/snake10 recordings/2024-09-foam --out foam.csv

Whatever the other verbs wrote is taken: solutions (those of sweeps and in folders of other machines too), diagnoses,
fits, campaigns as they were measured and compared, sets, plays; trials of a campaign that was not measured. A record
that cannot be read is a line with status `unreadable` and the reason (exit code 1). In Python:

    runs = pandas.read_csv("runs.csv")
    runs[runs.record == "solution"].plot.scatter("c", "displacement_body_lengths")
"""

from __future__ import annotations

import argparse
from pathlib import Path

from serpenoid.cli import options
from serpenoid.cli.target import target


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `table`."""
    parser.add_argument("folders", nargs="+", type=Path, metavar="FOLDER", help="results, campaigns, folders of them")
    parser.add_argument("--out", type=target, default=Path("runs.csv"), metavar="FILE", help="the table (runs.csv)")
    parser.add_argument("--force", action="store_true", help="write over a file that is no such table")
    options.add_output(parser)


def run(args: argparse.Namespace) -> int:
    """Collect, write, say how much."""
    from collections import Counter

    from serpenoid.errors import InputError
    from serpenoid.studies.many_runs import UNREADABLE, is_table, table_of, write_table

    if args.out.suffix != ".csv":
        raise InputError(f"--out {args.out}: must end in .csv.")
    options.check_writable(args.out.parent)
    if args.out.exists() and not (args.force and args.out.is_file()) and not is_table(args.out):
        raise InputError(
            f"--out {args.out}: is there and no table of runs. Name another file, or write over it by --force."
        )
    rows = table_of(args.folders)
    write_table(args.out, rows)
    counts = Counter(row["record"] for row in rows)
    words = ", ".join(f"{count} of {name}" for name, count in counts.items())
    options.report(args, rows, [f"{len(rows)} lines ({words})", f"written to {args.out}"])
    damaged = [row["message"] for row in rows if row.get("status") == UNREADABLE]
    for message in damaged:
        options.complain(f"{message} Its line holds no numbers.")
    return 1 if damaged else 0
