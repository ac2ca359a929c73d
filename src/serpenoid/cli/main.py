"""`serpenoid VERB ...`: finds the verb's module, and turns errors into one sentence and an exit code.

Exit codes: 0 done; 1 it ran and did not succeed (no optimum, a refused check); 2 bad input or usage; 130 Ctrl-C.
"""

from __future__ import annotations

import argparse
import importlib
import logging
import sys
from collections.abc import Sequence

from serpenoid.errors import InputError, StopRequested

# verb -> one line of help; the verb's module `serpenoid.cli.<verb>` has `configure(parser)` and `run(args) -> int`
VERBS: dict[str, str] = {
    "simulate": "simulate the gait of a problem file",
    "solve": "find the optimal gait of a problem file",
    "sweep": "solve the family of optimal gaits over the dissipation coefficient",
    "measure": "read a campaign of recordings: what is in it, what is missing, how good it is",
    "fit": "fit the anisotropy ratio to a campaign, with intervals",
    "compare": "lay measured, simulated and resimulated motion over each other",
    "diagnose": "find out what the simulation gets wrong, and why",
    "show": "say what is in a results folder",
    "effects": "list the physical effects that a model can have and a diagnosis can name",
    "schema": "print the schema of a problem file",
    "export": "write a gait for the robot: CSV, servo ticks, OpenRB-150 sketch, ROS 2",
    "play": "play a gait on the robot and record it",
    "robot": "find, check, rehearse and switch off the robot's servos",
    "arena": "play gaits in the virtual laboratory and write a campaign",
}

EPILOG = "Every verb explains itself: serpenoid VERB --help."


def build_parser(verb: str | None) -> argparse.ArgumentParser:
    """The parser; only the module of the named verb is imported, so `--help` stays quick."""
    parser = argparse.ArgumentParser(prog="serpenoid", description=__import__("serpenoid").__doc__, epilog=EPILOG)
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    for name, help_line in VERBS.items():
        formatter = argparse.RawDescriptionHelpFormatter
        sub = verbs.add_parser(name, help=help_line, description=help_line, formatter_class=formatter)
        if name == verb:
            module = importlib.import_module(f"serpenoid.cli.{name}")
            sub.description = module.__doc__
            module.configure(sub)
            sub.add_argument("-v", "--verbose", action="store_true", help="log what happens inside")
            sub.set_defaults(run=module.run)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    words = list(sys.argv[1:] if argv is None else argv)
    verb = next((word for word in words if not word.startswith("-")), None)
    args = build_parser(verb).parse_args(words)
    level = logging.DEBUG if args.verbose else logging.WARNING
    logging.basicConfig(level=level, format="%(levelname)s %(name)s: %(message)s")
    try:
        return args.run(args)
    except InputError as error:
        sys.stderr.write(f"serpenoid: {error}\n")
        return 2
    except (KeyboardInterrupt, StopRequested) as error:
        sys.stderr.write(f"\nserpenoid: stopped. {error}\n")
        return 130
    except BrokenPipeError:
        return 1


def entry() -> None:
    """Console script."""
    sys.exit(main())


if __name__ == "__main__":
    entry()
