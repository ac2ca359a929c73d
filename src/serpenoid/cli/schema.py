"""Print the JSON Schema of a file: every section and key, its type, default and meaning.

    serpenoid schema                    # of a problem file
    serpenoid schema robot              # problem, model, robot, protocol or campaign
    serpenoid schema robot --write .    # into ./.serpenoid/robot.schema.json, for editors

An editor that knows TOML schemas (taplo, Even Better TOML) then completes and checks a file that begins with the line
that --write prints; files of `serpenoid new` have it.
"""

from __future__ import annotations

import argparse
import json
import sys

from serpenoid.cli import options
from serpenoid.cli.target import target
from serpenoid.scaffold.json_schema import KINDS


def configure(parser: argparse.ArgumentParser) -> None:
    """KIND and --write."""
    parser.add_argument("kind", nargs="?", choices=KINDS, default="problem", metavar="KIND", help=", ".join(KINDS))
    parser.add_argument("--write", type=target, metavar="DIR", help="write it into DIR; print the line that names it")


def run(args: argparse.Namespace) -> int:
    """Print or write."""
    from serpenoid.scaffold.json_schema import schema_of, write_schema

    if args.write is not None:
        options.check_writable(args.write, "--write")
        sys.stdout.write(write_schema(args.write, args.kind) + "\n")
        return 0
    sys.stdout.write(json.dumps(schema_of(args.kind), indent=2) + "\n")
    return 0
