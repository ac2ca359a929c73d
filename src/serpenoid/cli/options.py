"""Options that several verbs share, and how they report."""

from __future__ import annotations

import argparse
import json
import logging
import os
import sys
import tempfile
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from serpenoid.parallel import Workers
    from serpenoid.problem import Problem

from serpenoid.cli.claim import claim
from serpenoid.cli.log import settle
from serpenoid.cli.target import target

log = logging.getLogger(__name__)
SUMMARY = "summary.txt"  # what the command said, in its results folder
MODEL_HELP = (
    "model file whose medium and effects (and body, where it has a [body]) replace the problem's; another body is told"
)
SET_HELP = (
    "override a value of the problem file, e.g. --set medium.anisotropy_ratio=0.1 (repeatable); "
    "another gait.family begins [gait] and [task.bounds] anew"
)


def add_problem(parser: argparse.ArgumentParser) -> None:
    """PROBLEM, --model and --set."""
    parser.add_argument("problem", metavar="PROBLEM", help="problem file, e.g. problems/snake10.toml")
    add_model(parser)
    add_set(parser)


def add_model(parser: argparse.ArgumentParser) -> None:
    """--model."""
    parser.add_argument("--model", metavar="FILE", help=MODEL_HELP)


def add_set(parser: argparse.ArgumentParser) -> None:
    """--set."""
    parser.add_argument("--set", action="append", default=[], metavar="SECTION.KEY=VALUE", help=SET_HELP)


def add_output(parser: argparse.ArgumentParser, out: str = "") -> None:
    """--quiet, --json, and for results --out, --no-figures; out: what the folder is without --out."""
    if out:
        parser.add_argument("--out", type=target, metavar="DIR", help=f"results folder (default: {out})")
        parser.add_argument("--force", action="store_true", help="move another answer in the folder aside")
        parser.add_argument("--no-figures", action="store_true", help="write numbers only")
        add_open(parser)
    parser.add_argument("--quiet", action="store_true", help="no progress, no summary")
    parser.add_argument("--json", action="store_true", help="print the record as JSON on standard output, nothing else")


def add_workers(parser: argparse.ArgumentParser, things: str, jobs: int = 1, tasks: str | None = None) -> None:
    """--jobs, --cluster; `tasks`: what runs on a cluster, where that is something else."""
    parser.add_argument("--jobs", "-j", type=positive, default=jobs, metavar="N", help=f"{things} at a time ({jobs})")
    help_line = (
        f"{tasks or things} on a Dask cluster: its scheduler's address, or local:N for N workers on this machine"
    )
    parser.add_argument("--cluster", metavar="ADDRESS", help=help_line)


def workers(args: argparse.Namespace) -> Workers:
    """What --jobs and --cluster ask for."""
    from serpenoid.parallel import Workers

    return Workers(args.jobs, args.cluster)


def add_open(parser: argparse.ArgumentParser) -> None:
    """--open."""
    parser.add_argument("--open", action="store_true", help="open the report (or the picture that says most)")


def open_page(args: argparse.Namespace, folder: Path) -> None:
    """With --open: the folder's report in the browser, else a picture; a sentence where there is nothing to open."""
    if not getattr(args, "open", False):
        return
    pictures = sorted(folder.glob("*.png"), key=lambda path: (path.name not in TELLING, path.name))
    pages = [*sorted(folder.glob("*.html")), *pictures]
    if not pages:
        complain(f"--open: {folder} has neither a report nor a picture. Was it run with --no-figures?")
    elif not webbrowser.open(pages[0].resolve().as_uri()):
        complain(f"--open: no browser was found. The page: {pages[0]}")


TELLING = {"motion.png", "family.png"}  # what an answer does, and a sweep: no folder has both
MOST = 100_000  # of starts, gaits, trials: nobody waits for the last


def positive(text: str) -> int:
    """A whole number of at least 1."""
    return _whole(text, 1, MOST)


def seed(text: str) -> int:
    """A whole number of at least 0."""
    return _whole(text, 0, 2**63 - 1)


def _whole(text: str, least: int, most: int) -> int:
    try:
        number = int(text)
    except ValueError:
        number = least - 1
    if not least <= number <= most:
        raise argparse.ArgumentTypeError(f"needs a whole number from {least} to {most}, got {text[:20]!r}")
    return number


def report(args: argparse.Namespace, record: Any, lines: list[str], folder: Path | None = None) -> None:
    """Print the record (--json), nothing (--quiet) or the summary; keep the summary in the folder, and --open it."""
    if args.json:
        sys.stdout.write(json.dumps(record, indent=2) + "\n")
    elif not args.quiet:
        sys.stdout.write("\n".join(lines) + "\n")
    if folder is not None:
        from serpenoid.files.writing import write_text

        write_text(folder / SUMMARY, "\n".join(lines) + "\n")
        open_page(args, folder)


def signed(value: float) -> str:
    """Six decimals with a sign, but none before nothing."""
    return f"{value:+.6f}" if abs(value) >= 5e-7 else "0"


def complain(message: str) -> None:
    """A sentence on standard error."""
    log.info("said: %s", message)
    sys.stderr.write(f"serpenoid: {message}\n")


def warn_of_problem(problem: Problem) -> None:
    """Sentences on standard error before the work, with --quiet too.

    They are of another body than the file's, of numbers that may be in another unit, of a speed limit that cannot hold.
    """
    if problem.body_note is not None:
        complain(f"{problem.body_note}.")
    for said in problem.odd_units:
        complain(f"warning: {said}")
    if problem.joint_speed_limit_rpm is not None and problem.task.cycle_duration_s is None:
        complain(
            f"joint_speed_limit_rpm = {problem.joint_speed_limit_rpm:g} does not hold: without `cycle_duration_s` in "
            "[task] no joint has a speed. Give the duration, or leave out the limit."
        )


WIDE_BAR, NARROW_BAR, WIDE = 40, 16, 120  # columns of the bar, and of a terminal that has room for the wide one


class Advance(Protocol):
    """What a progress bar offers: done so far, and a word about it."""

    def __call__(self, done: float, text: str = "", total: float = ...) -> None: ...


@contextmanager
def progress_bar(
    args: argparse.Namespace, title: str, total: float, left: Callable[[], float] | None = None
) -> Iterator[Advance]:
    """A bar on standard error with the time that is left; silent with --quiet and --json. The log hears every step.

    total: how much work there is, in whatever `done` counts: remaining time is true as far as its units take as long
    as each other. left: seconds until the end, where the work knows them better.
    """
    if args.quiet or args.json:
        yield lambda done, text="", total=total: _note(title, done, total, text)
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn
    from rich.table import Column

    from serpenoid.cli.remaining import RemainingColumn

    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=WIDE_BAR if console.width >= WIDE else NARROW_BAR),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        RemainingColumn(),
        TextColumn("{task.fields[note]}", table_column=Column(ratio=1, no_wrap=True, overflow="ellipsis")),  # gives way
    )
    with Progress(*columns, console=console, expand=True) as bar:
        task = bar.add_task(title, total=total, note="", left=left)
        bar.live.transient = True  # a bar of work that never began is no news

        def advance(done: float, text: str = "", total: float = total) -> None:
            _note(title, done, total, text)
            bar.live.transient = False
            bar.update(task, completed=done, total=total, note=text)

        yield advance


def _note(title: str, done: float, total: float, text: str) -> None:
    log.info("%s: %g of %g %s", title, done, total, text)


def output_folder(args: argparse.Namespace, default: Path, *key: Any) -> Path:
    """--out or the default; refused before the work begins where it could not be written after it, or is taken.

    key: what the answer depends on.
    """
    folder = Path(args.out) if args.out else default
    check_writable(folder)
    settle([folder])
    return claim(args, folder, *key)


def check_writable(folder: Path, option: str = "--out") -> None:
    """InputError where `folder` neither exists nor can be made, or cannot be written to."""
    from serpenoid.errors import InputError

    there = next(path for path in (folder.absolute(), *folder.absolute().parents) if os.path.lexists(path))
    if not os.path.exists(there):
        raise InputError(f"{option} {folder}: {there} is a link to what is not there.")
    if not there.is_dir():
        raise InputError(f"{option} {folder}: {there} is a file, not a folder.")
    try:
        with tempfile.TemporaryFile(dir=there):
            pass
    except OSError as error:
        raise InputError(f"{option} {folder}: {there} cannot be written to ({error.strerror}).") from None
