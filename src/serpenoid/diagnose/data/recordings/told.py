"""What a log's own commands say of a trial: when it began, and whether rows are held or run through on straight lines.

Commands that hold rows may be goals (`set_points`), due one row later, unless labels say that they were due at once.
Commands and readings are on one clock. Between two rows of a slow log the table is known better than the commands are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.measure.logs import TICK, ServoLog
from serpenoid.measure.schedule import Schedule, start_by_shape

STEPS = 40  # to either side, twice: first of a row of the table, then of what that leaves open
PARTS = 9  # of these, so that what one needs stays in a core's cache
CHANCE = 4.0  # two standard deviations, squared
LEAST_ROWS = 8
ROUNDED = 1.2  # times what rounding to ticks makes: as much may be chance
AT_ONCE_S = 1e-3  # over which a speed is taken


@dataclass(frozen=True)
class Told:
    """start_s: t0 on the servos' clock; spread_s: half of what is left open of it; held: rows stay until the next;
    by_log: rows were due by the log's clock, for all that the commands say, and else by the cameras'; goals: held rows
    may be goals."""

    start_s: float
    spread_s: float
    held: bool
    by_log: bool
    goals: bool = False


def told_by_commands(log: ServoLog, schedule: Schedule, rate: float, labelled: float | None = None) -> Told | None:
    """What the commands say; None where they are not the table to within a tick of a servo, or are so in both ways.

    labelled: servo time [s] of t0 by the log's labels, which say which cycle is which; commands of each are alike.
    rate: of the servos' clock beside the cameras'; the commands may follow either, and where they exclude neither, the
    start is as open as both leave it: a rate that noisy markers tell badly moves it by more than a slow log's rows do.
    """
    if log.command is None:
        return None
    known = np.isfinite(log.command).all(axis=1)
    time, command = log.time_s[known], log.command[known]
    roughly = start_by_shape(schedule, time, command)
    if roughly is None:
        return None
    if labelled is not None:
        cycles = round((labelled - roughly.offset_s) / schedule.period_s)
        roughly = replace(roughly, offset_s=roughly.offset_s + cycles * schedule.period_s)
    row = schedule.row_s
    inside = (time > roughly.offset_s + row) & (time < roughly.offset_s + schedule.moving_s - row)
    if inside.sum() < LEAST_ROWS:
        return None
    time, command = time[inside], command[inside]
    apart, found, size = Distances.of(command, schedule.closed), list[Told](), command.size
    for held in (False, True):
        plan = replace(schedule, held=held)
        ways = [_open(time, apart, plan, roughly.offset_s, row, r) for r in (0.0, rate)]
        least = min(square for square, _, _ in ways)
        if least <= size * TICK**2:
            left = [way for way in ways if way[0] <= least + _slack(least, size)]
            first, last = min(low for _, low, _ in left), max(high for _, _, high in left)
            start = (first + last) / 2
            goals = held and (labelled is None or labelled - start > row / 2)
            stale = 0.0 if held else _stale(least / size, plan, time - start)
            found.append(Told(start, (last - first) / 2 + stale, held, ways[0] in left, goals))
    return found[0] if len(found) == 1 else None


def _open(
    time: Floats, apart: Distances, plan: Schedule, roughly: float, row: float, rate: float
) -> tuple[float, float, float]:
    """Squares [rad^2] of what commands miss of the table at least, and the first and last start that leave as much."""
    low, high = roughly - row, roughly + row
    size = len(time) * plan.table.shape[1]
    for _ in range(2):
        tried = np.linspace(low, high, 2 * STEPS + 1)
        parts = np.array_split(tried, PARTS)
        squares = np.concatenate([apart.squares(plan, (time - t[:, None]) / (1 + rate)) for t in parts])
        least = float(squares.min())
        open_ = np.flatnonzero(squares <= least + _slack(least, size))
        first, last = max(open_[0] - 1, 0), min(open_[-1] + 1, len(tried) - 1)
        low, high = float(tried[first]), float(tried[last])
    return least, low, high


def _stale(missed: float, plan: Schedule, time: Floats) -> float:
    """By how much [s] commands lag in the middle that miss a table that runs, at times (R,) of it, by such a mean
    square, more than a rounding does [rad^2]: those that a player renews at its own pace, and a log reads now and then,
    are late by anything from nothing to its interval, a mean of sqrt(3) times their standard deviation. Servos need not
    be as late."""
    if missed < ROUNDED * TICK**2 / 12:
        return 0.0
    speed = (plan.commanded(time + AT_ONCE_S) - plan.commanded(time - AT_ONCE_S)) / (2 * AT_ONCE_S)
    return float(np.sqrt(3 * missed / max((speed**2).mean(), 1e-12)))


def _slack(least: float, size: int) -> float:
    """Squares that so many commands, which miss the table by `least`, miss more by chance."""
    return CHANCE * max(least / size, TICK**2 / 12)


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
