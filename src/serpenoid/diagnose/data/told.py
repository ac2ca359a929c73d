"""What a log's own commands say of a trial: when it began, and whether rows are held or run through on straight lines.

Commands and readings are on one clock. Between two rows of a slow log the table is known better than the commands are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.noise import TICK
from serpenoid.measure.logs import ServoLog
from serpenoid.measure.schedule import Schedule, start_by_shape

STEPS = 40  # to either side, twice: first of a row of the table, then of what that leaves open
PARTS = 9  # of these, so that what one needs stays in a core's cache
CHANCE = 4.0  # two standard deviations, squared
LEAST_ROWS = 8


@dataclass(frozen=True)
class Told:
    """start_s: t0 on the servos' clock; spread_s: half of what is left open of it; held: rows stay until the next."""

    start_s: float
    spread_s: float
    held: bool


def told_by_commands(log: ServoLog, schedule: Schedule, rate: float) -> Told | None:
    """What the commands say; None where they are not the table to within a tick of a servo, or are so in both ways.

    rate: of the servos' clock beside the cameras'; the commands may follow either.
    """
    if log.command is None:
        return None
    known = np.isfinite(log.command).all(axis=1)
    time, command = log.time_s[known], log.command[known]
    roughly = start_by_shape(schedule, time, command)
    if roughly is None:
        return None
    row = schedule.cycle_duration_s / len(schedule.table)
    inside = (time > roughly.offset_s + row) & (time < roughly.offset_s + schedule.moving_s - row)
    if inside.sum() < LEAST_ROWS:
        return None
    time, command = time[inside], command[inside]
    apart, found = Distances.of(command, schedule.closed), list[Told]()
    for held in (False, True):
        plan = replace(schedule, held=held)
        ways = [_start(time, apart, plan, roughly.offset_s, row, r) for r in (0.0, rate)]
        missed, start, spread = min(ways)
        if missed <= TICK:
            found.append(Told(start, spread, held))
    return found[0] if len(found) == 1 else None


def _start(
    time: Floats, apart: Distances, plan: Schedule, roughly: float, row: float, rate: float
) -> tuple[float, float, float]:
    """RMS [rad] of what commands miss of the table, and the start that leaves least: its middle and half its width."""
    low, high = roughly - row, roughly + row
    size = len(time) * plan.table.shape[1]
    for _ in range(2):
        tried = np.linspace(low, high, 2 * STEPS + 1)
        parts = np.array_split(tried, PARTS)
        squares = np.concatenate([apart.squares(plan, (time - t[:, None]) / (1 + rate)) for t in parts])
        least = float(squares.min())
        slack = CHANCE * max(least / size, TICK**2 / 12)
        open_ = np.flatnonzero(squares <= least + slack)
        first, last = max(open_[0] - 1, 0), min(open_[-1] + 1, len(tried) - 1)
        low, high = float(tried[first]), float(tried[last])
    return float(np.sqrt(least / size)), (low + high) / 2, (high - low) / 2


@dataclass(frozen=True)
class Distances:
    """Squares of what commands (R, m) miss the rows of a table by, T of them and the first once more.

    By a share s of the step d from row b to the next, a command c misses |c - b|^2 - 2 s (c - b) d + s^2 d^2.
    off (R, T + 1): the first of these; along (R, T + 1): twice (c - b) d; wide (T + 1,): d^2.
    """

    off: Floats
    along: Floats
    wide: Floats

    @classmethod
    def of(cls, command: Floats, rows: Floats) -> Distances:
        step = np.diff(rows, axis=0, append=rows[-1:])
        off = sum((c[:, None] - b) ** 2 for c, b in zip(command.T, rows.T, strict=True))
        along = 2 * (command @ step.T - (rows * step).sum(axis=1))
        return cls(np.asarray(off), along, (step**2).sum(axis=1))

    def squares(self, plan: Schedule, time: Floats) -> Floats:
        """Their sums (K,) if commands were given at times (K, R) of a plan."""
        row, share = plan.rows_at(time)
        at = np.arange(len(self.off)) * self.off.shape[1] + row
        missed = self.off.ravel()[at]
        if not plan.held:
            missed += share * (share * self.wide[row] - self.along.ravel()[at])
        return np.asarray(missed.sum(axis=1))
