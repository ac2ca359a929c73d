"""`serpenoid VERB ...`: finds the verb's module, and turns errors into one sentence and an exit code.

Exit codes: 0 done; 1 it ran and did not succeed (no optimum, a refused check); 2 bad input or usage; 130 Ctrl-C
or SIGTERM.
"""

from __future__ import annotations

import argparse
import errno
import importlib
import io
import os
import re
import sys
import textwrap
from collections.abc import Sequence
from contextlib import ExitStack
from typing import Any, NoReturn

import serpenoid
from serpenoid import interrupts
from serpenoid.cli import log
from serpenoid.cli.target import target
from serpenoid.errors import InputError, StopRequested
from serpenoid.wording import meant

# verb -> one line of help; the verb's module `serpenoid.cli.<verb>` has `configure(parser)` and `run(args) -> int`
VERBS: dict[str, str] = {
    "new": "write a commented file to begin with: problem, robot, protocol, campaign",
    "simulate": "simulate the gait of a problem file",
    "solve": "find the optimal gait of a problem file",
    "sweep": "solve the family of optimal gaits over the dissipation coefficient",
    "campaign": "take a recorded trial into a campaign",
    "measure": "read a campaign of recordings: what is in it, what is missing, how good it is",
    "fit": "fit the anisotropy ratio to a campaign, with intervals",
    "compare": "lay measured, simulated and resimulated motion over each other",
    "diagnose": "find out what the simulation gets wrong, and why",
    "show": "say what is in a results folder",
    "table": "all results in some folders as one CSV",
    "effects": "list the physical effects that a model can have and a diagnosis can name",
    "schema": "print the JSON Schema of a file: problem, model, robot, protocol, campaign",
    "export": "write a gait for the robot: CSV, servo ticks, OpenRB-150 sketch, ROS 2",
    "play": "play a gait on the robot and record it",
    "robot": "find, check, rehearse and switch off the robot's servos",
    "arena": "play gaits in the virtual laboratory and write a campaign",
    "reproduce": "the paper's whole protocol in the arena, start to figures",
    "examples": "copy the examples that come with the package",
    "completion": "print a script for the shell to complete commands",
}

ANEW = "The same command begins anew."  # of one that keeps nothing before its answer
NARROW = 78  # columns of a line that every terminal shows whole
EPILOG = "Every verb explains itself: serpenoid VERB --help."


class _Help(argparse.RawDescriptionHelpFormatter):
    """Paragraphs stand as they are written, and no line ends within a word, an option or a path."""

    def _split_lines(self, text: str, width: int) -> list[str]:
        return textwrap.wrap(" ".join(text.split()), width, break_long_words=False, break_on_hyphens=False)

    def add_argument(self, action: argparse.Action) -> None:
        super().add_argument(action)
        if isinstance(action, argparse._SubParsersAction):  # verbs stand farther in, which argparse leaves out of count
            self._action_max_length += self._indent_increment


class _Parser(argparse.ArgumentParser):
    """Says what to write where a value looks like an option; parsers of verbs and their actions are of its kind."""

    def __init__(self, **given: Any) -> None:
        super().__init__(**{"formatter_class": _Help} | given)

    def error(self, message: str) -> NoReturn:
        option = re.match(r"argument (--[\w-]+)\S*: expected one argument", message)
        said = "" if option is None else f"; a value that begins with `-` is given as {option[1]}=VALUE"
        super().error(message + said)


def build_parser(*complete: str | None) -> argparse.ArgumentParser:
    """The parser; only the modules of the named verbs are imported, so `--help` stays quick."""
    parser = _Parser(prog="serpenoid", description=textwrap.fill(str(serpenoid.__doc__), NARROW), epilog=EPILOG)
    parser.add_argument("--version", action="version", version=f"serpenoid {serpenoid.__version__}")
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    for name, help_line in VERBS.items():
        sub = verbs.add_parser(name, help=help_line, description=help_line)
        if name in complete:
            module = importlib.import_module(f"serpenoid.cli.{name}")
            sub.description = module.__doc__
            module.configure(sub)
            sub.set_defaults(run=module.run, verbose=False, log_file=None)
            _add_logging(sub)
    return parser


def _meant(parser: argparse.ArgumentParser, args: argparse.Namespace) -> argparse.ArgumentParser:
    """The parser of the verb, and of its action: their usage says what can be written, the program's does not."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            below: argparse.ArgumentParser = action.choices[getattr(args, action.dest)]
            return _meant(below, args)
    return parser


def _add_logging(parser: argparse.ArgumentParser) -> None:
    """-v and --log-file after the verb, and after each of its actions: what neither says is the verb's default."""
    parser.add_argument(
        "-v", "--verbose", action="store_true", default=argparse.SUPPRESS, help="log what happens inside"
    )
    parser.add_argument(
        "--log-file", type=target, metavar="FILE", default=argparse.SUPPRESS, help="the same into a file, with times"
    )
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for nested in dict.fromkeys(action.choices.values()):
                _add_logging(nested)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    if isinstance(sys.stdout, io.TextIOWrapper):  # letters that the terminal's encoding lacks are written as escapes
        sys.stdout.reconfigure(errors="backslashreplace")
    words = list(sys.argv[1:] if argv is None else argv)
    verb = next((word for word in words if not word.startswith("-")), None)
    if verb is not None and verb not in VERBS and words[0] == verb:
        hint = meant(verb, VERBS) or f" Verbs: {', '.join(VERBS)}."
        build_parser().error(f"argument VERB: there is no verb `{verb}`.{hint}")
    parser = build_parser(verb)
    if empty := next((word for word in words if re.fullmatch(r"--[\w-]+=--", word)), None):
        parser.error(f"argument {empty[:-3]}: expected one argument")  # argparse would give an empty list
    args, unknown = parser.parse_known_args(words)
    if unknown:
        _meant(parser, args).error(f"unrecognized arguments: {' '.join(unknown)}")
    try:
        logging = log.begin(args, words)
    except InputError as error:
        return _complain(str(error), 2)
    with logging, interrupts.listening() as interrupted, ExitStack() as args.held:  # what nobody else may use
        return log.ended(_run(args, interrupted))


def _run(args: argparse.Namespace, interrupted: list[int]) -> int:
    if sys.stdout is None:  # closed by the shell: >&-
        unheard = getattr(args, "works_unheard", False)  # a verb that must go on says it all on standard error
        if not (getattr(args, "quiet", False) or unheard):
            return _complain("standard output is closed, so nothing can be printed; open it, or give --quiet.", 2)
        nowhere = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - to the end of the process
        sys.stdout = sys.stderr if unheard and sys.stderr is not None else nowhere
    try:
        code = args.run(args)
        if code in (0, 1) and getattr(args, "requests", None):
            importlib.import_module("serpenoid.cli.claim").finish(args)
        sys.stdout.flush()
        return code
    except (KeyboardInterrupt, StopRequested) as error:
        return _stopped(args, str(error))
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or Python complains once more as it ends
        return 130 if interrupted else 1
    except Exception as error:
        if interrupted:  # whatever a library made of it
            log.stopped()
            return _stopped(args)
        code = _refused(error, args)
        if code is None:
            log.failed()
            raise
        return code


def _stopped(args: argparse.Namespace, reason: str = "") -> int:
    if getattr(args, "requests", None):
        importlib.import_module("serpenoid.cli.claim").leave_word(args)
    return stopped(reason or _kept(args))


def _kept(args: argparse.Namespace) -> str:
    """What the verb says is left of its work, a sentence or what finds one."""
    said = getattr(args, "kept_if_stopped", ANEW if getattr(args, "requests", None) else "")
    return str(said() if callable(said) else said)


def _refused(error: Exception, args: argparse.Namespace) -> int | None:
    """Misuse, and what the system refuses, in one sentence; None: a fault of ours."""
    if isinstance(error, InputError):
        return _complain(_located(str(error), args), 2)
    if isinstance(error, OSError):
        named_badly = error.errno == errno.ENAMETOOLONG  # by whoever gave the command
        return _complain(f"{error.filename or 'standard output'}: {error.strerror or error}.", 2 if named_badly else 1)
    return None


def _located(message: str, args: argparse.Namespace) -> str:
    """What begins with a section of the problem file, found after it was read, names the file too."""
    file = getattr(args, "problem", None)
    return f"{file}: {message}" if message.startswith("[") and isinstance(file, str) else message


def _complain(message: str, code: int) -> int:
    log.log.debug("said: %s", message)
    sys.stderr.write(f"serpenoid: {message}\n")
    return code


def stopped(reason: object = "") -> int:
    """Exit code of a command that Ctrl-C ended, said on standard error."""
    return _complain(f"stopped. {reason}".rstrip(), 130)
