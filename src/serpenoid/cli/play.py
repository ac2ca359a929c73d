"""Play a gait on the robot and record it.

RESULTS is a results folder or a joint-table CSV. Before anything moves the table, the servos and the battery are
checked; then the robot approaches the first row slowly, plays the cycles, and torque is switched off: at the end, on
any fault, on Ctrl-C, and on the emergency keys (space, Esc, q). A joint that does not follow its command stops the
robot, slows it down or is reported, as [tracking] of the robot file says; exit code 0 means that all of them followed.

  serpenoid play RESULTS --robot problems/robots/snake10-robot.toml --dry-run
  serpenoid play RESULTS --robot problems/robots/snake10-robot.toml --cycles 3 --pause 2 --log trials/gait01-a-1

--log DIR receives servo.csv, joint_table.csv (as played), play.json and trial.toml (a section for campaign.toml).
A transient is played once, and its last row is held for the pause; campaigns know closed gaits alone.
No robot at hand? `serpenoid robot emulate` prints a port to rehearse on.
"""

from __future__ import annotations

import argparse
import contextlib
import sys
import time
from pathlib import Path

from serpenoid.cli.robot_arguments import (
    add_robot,
    add_table,
    add_widen,
    checked_table,
    load_robot,
    planned,
    sentence,
    tell,
    warn,
)
from serpenoid.cli.target import target
from serpenoid.robot.dry_run import describe
from serpenoid.robot.port import resolve_port
from serpenoid.robot.session import Outcome, TrialFiles, play_trial

EXIT_CODES = {"done": 0, "strayed": 1, "failed": 1, "stopped": 130}


def configure(parser: argparse.ArgumentParser) -> None:
    parser.set_defaults(works_unheard=True)  # what becomes of the motors is said on standard error and in the log
    add_table(parser)
    add_robot(parser, port="auto")
    parser.add_argument("--cycles", type=int, default=1, metavar="N", help="cycles to play (default 1)")
    parser.add_argument("--pause", type=float, default=0.0, metavar="S", help="rest after each cycle [s] (default 0)")
    parser.add_argument("--log", "--out", type=target, metavar="DIR", help="record into this folder, a new one")
    parser.add_argument("--power-port", metavar="PORT", help="serial port of an INA260 stream: power.csv in DIR")
    add_widen(parser)
    parser.add_argument("--dry-run", action="store_true", help="print what would be sent; touch no port")


def run(args: argparse.Namespace) -> int:
    robot = load_robot(args)
    table, refusals = checked_table(args, robot)
    if refusals:
        warn("refused, nothing has moved:", *refusals)
        return 1
    plan = planned(args, table, robot)
    if args.dry_run:
        sys.stdout.writelines(line + "\n" for line in describe(plan))
        return 0
    files = TrialFiles(args.log, args.power_port)
    progress = StatusLine()
    outcome = play_trial(resolve_port(args.port), plan, files, progress)
    progress.finish()
    _report(outcome, args.log)
    return EXIT_CODES[outcome.status] or (0 if outcome.torque_off else 1)


def _report(outcome: Outcome, folder: Path | None) -> None:
    lines = [sentence(f"{outcome.status}: {outcome.reason}"), sentence(f"motors: {outcome.torque}")]
    lines.append(f"schedule: {outcome.timing}.")
    if outcome.tracking:
        lines.append(f"tracking: {outcome.tracking}.")
    if outcome.numbers.get("failed_exchanges"):
        failed = ", ".join(f"servo {servo}: {count}" for servo, count in outcome.numbers["failed_exchanges"].items())
        lines.append(f"bus: exchanges that failed and were repeated: {failed}.")
    lines += [f"note: {sentence(note)}" for note in outcome.notes]
    if folder is not None and (folder / "servo.csv").exists():
        lines.append(f"recording: {folder}")
    tell(sys.stdout if outcome.status == "done" and outcome.torque_off else sys.stderr, *lines)


class StatusLine:
    """Progress on stderr: one line that renews itself on a terminal, new stages only elsewhere.

    A terminal that went away, or a closed stderr, is no reason to stop a robot.
    """

    def __init__(self) -> None:
        self._terminal = sys.stderr is not None and sys.stderr.isatty()
        self._last = 0.0
        self._stage = ""

    def __call__(self, text: str) -> None:
        stage, _, _ = text.partition(", step")
        is_new, self._stage = stage != self._stage, stage
        if self._terminal and (is_new or time.monotonic() - self._last > 0.2):
            self._last = time.monotonic()
            self._write(f"\r\x1b[K{text}")
        elif not self._terminal and is_new:
            self._write(stage + "\n")

    def finish(self) -> None:
        if self._terminal:
            self._write("\r\x1b[K")

    def _write(self, text: str) -> None:
        with contextlib.suppress(OSError, ValueError, AttributeError):
            sys.stderr.write(text)
            sys.stderr.flush()
