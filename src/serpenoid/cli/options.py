"""Options that several verbs share, and how they report."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

SET_HELP = "override a number of the problem file, e.g. --set medium.anisotropy_ratio=0.1 (repeatable)"


def add_problem(parser: argparse.ArgumentParser) -> None:
    """PROBLEM, --model and --set."""
    parser.add_argument("problem", metavar="PROBLEM", help="problem file, e.g. problems/snake10.toml")
    add_model(parser)
    add_set(parser)


def add_model(parser: argparse.ArgumentParser) -> None:
    """--model."""
    parser.add_argument("--model", metavar="FILE", help="model file whose medium and effects replace the problem's")


def add_set(parser: argparse.ArgumentParser) -> None:
    """--set."""
    parser.add_argument("--set", action="append", default=[], metavar="SECTION.KEY=VALUE", help=SET_HELP)


def add_output(parser: argparse.ArgumentParser, out: str = "") -> None:
    """--quiet, --json, and for results --out, --no-figures; out: what the folder is without --out."""
    if out:
        parser.add_argument("--out", metavar="DIR", help=f"results folder (default: {out})")
        parser.add_argument("--no-figures", action="store_true", help="write numbers only")
    parser.add_argument("--quiet", action="store_true", help="no progress, no summary")
    parser.add_argument("--json", action="store_true", help="print the record as JSON on standard output, nothing else")


def positive(text: str) -> int:
    """A whole number of at least 1."""
    return _whole(text, 1)


def seed(text: str) -> int:
    """A whole number of at least 0."""
    return _whole(text, 0)


def _whole(text: str, least: int) -> int:
    try:
        number = int(text)
    except ValueError:
        number = least - 1
    if number < least:
        raise argparse.ArgumentTypeError(f"needs a whole number of at least {least}, got {text!r}")
    return number


def report(args: argparse.Namespace, record: Any, lines: list[str]) -> None:
    """Print the record (--json), nothing (--quiet) or the summary."""
    if args.json:
        sys.stdout.write(json.dumps(record, indent=2) + "\n")
    elif not args.quiet:
        sys.stdout.write("\n".join(lines) + "\n")


def complain(message: str) -> None:
    """A sentence on standard error."""
    sys.stderr.write(f"serpenoid: {message}\n")


class Advance(Protocol):
    """What a progress bar offers: done so far, and a word about it."""

    def __call__(self, done: int, text: str = "") -> None: ...


@contextmanager
def progress_bar(args: argparse.Namespace, title: str, total: int) -> Iterator[Advance]:
    """A bar on standard error; silent with --quiet and --json, plain lines where there is no terminal."""
    if args.quiet or args.json:
        yield lambda done, text="": None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, TextColumn("{task.fields[note]}"), console=console) as bar:
        task = bar.add_task(title, total=total, note="")

        def advance(done: int, text: str = "") -> None:
            bar.update(task, completed=done, note=text)

        yield advance


def output_folder(args: argparse.Namespace, default: Path) -> Path:
    """--out or the default; refused before the work begins where it could not be written after it."""
    folder = Path(args.out) if args.out else default
    check_writable(folder)
    return folder


def check_writable(folder: Path) -> None:
    """InputError where `folder` neither exists nor can be made, or cannot be written to."""
    from serpenoid.errors import InputError

    there = next(path for path in (folder.absolute(), *folder.absolute().parents) if path.exists())
    if not there.is_dir():
        raise InputError(f"--out {folder}: {there} is a file, not a folder.")
    try:
        with tempfile.TemporaryFile(dir=there):
            pass
    except OSError as error:
        raise InputError(f"--out {folder}: {there} cannot be written to ({error.strerror}).") from None
