"""When which row of the table was commanded (docs/campaign-format.md), and where a trial's cycles lie in its recording.

Row i of cycle n is commanded at t0 + n (cycle_duration_s + pause_s) + i cycle_duration_s / T.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from serpenoid.measure.cells import Floats
from serpenoid.measure.clock import Offset, find_offset
from serpenoid.measure.logs import ServoLog

ON_TIME = 1e-9  # rows: rounding of a time at which one is due
SETTLE = 0.5  # of the pause: servos lag, and the rest of the motion happens after the last command


@dataclass(frozen=True)
class Schedule:
    """A table (T, m) played `cycles` times from `start_s`, with a pause after each.

    held: a row stays commanded until the next is due; else the command runs to the next row on a straight line.
    """

    table: Floats
    cycle_duration_s: float
    cycles: int
    pause_s: float
    start_s: float = 0.0
    held: bool = False

    @property
    def row_s(self) -> float:
        """Seconds from row to row."""
        return self.cycle_duration_s / len(self.table)

    @property
    def jumps_every_s(self) -> float:
        """Seconds from one jump to the next; 0 where no row jumps."""
        return self.row_s if self.held else 0.0

    @property
    def period_s(self) -> float:
        return self.cycle_duration_s + self.pause_s

    @property
    def whole_s(self) -> float:
        """From the first command to the end of the last pause."""
        return self.cycles * self.period_s

    @property
    def end_s(self) -> float:
        return self.start_s + self.whole_s

    @property
    def moving_s(self) -> float:
        """From the first command to the last: without the pause after the last cycle."""
        return self.cycles * self.cycle_duration_s + (self.cycles - 1) * self.pause_s

    def until(self, end_s: float) -> Schedule:
        """No more cycles than begin so many seconds after the first, and one: its first row is where pauses rest."""
        begun = int(np.ceil(max(end_s, 0.0) / self.period_s))
        return replace(self, cycles=min(self.cycles, begun + 1))

    def seen_in(self, seconds: float) -> Schedule:
        """No more cycles than so long a recording can show, with one before and one after."""
        return replace(self, cycles=int(min(self.cycles, np.ceil(seconds / self.period_s) + 2)))

    def commanded(self, time_s: Floats) -> Floats:
        """Commanded joint angles (R, m); row 0 before the start, in pauses and after the end."""
        (row, share), closed = self.rows_at(np.asarray(time_s)), self.closed
        before = closed[row]
        return before if self.held else np.asarray(before + share[:, None] * (closed[row + 1] - before))

    @property
    def closed(self) -> Floats:
        """The table and its first row once more (T + 1, m)."""
        return np.concatenate([self.table, self.table[:1]])

    def rows_at(self, time_s: Floats) -> tuple[NDArray[np.int64], Floats]:
        """Rows of `closed` that were commanded last, and which share of the way to the next has passed, at times of
        any shape."""
        since = time_s - self.start_s
        phase = np.where(since < 0, 0.0, np.mod(since, self.period_s) / self.cycle_duration_s)
        at = np.where(since >= self.whole_s, 0.0, np.minimum(phase, 1.0)) * len(self.table)
        if self.held:
            return (at + ON_TIME).astype(int), np.zeros_like(at)
        row = np.minimum(at.astype(int), len(self.table) - 1)
        return row, at - row

    def phase(self, time_s: Floats) -> Floats:
        """Cycles since the start of each cycle, 0..1, holding 1 in the pauses."""
        since = np.mod(np.asarray(time_s) - self.start_s, self.period_s)
        return np.asarray(np.minimum(since / self.cycle_duration_s, 1.0))

    def window_s(self, cycle: int) -> tuple[float, float]:
        """First command of a cycle to half-way through its pause."""
        begin = self.start_s + cycle * self.period_s
        return begin, begin + self.cycle_duration_s + SETTLE * self.pause_s


def start_by_log(log: ServoLog, cycle_duration_s: float, pause_s: float, rows: int) -> float | None:
    """t0 on the log's clock, None where the log does not say.

    The first log row of every (cycle, step) is late by up to one log interval: the earliest ones tell.
    """
    if log.phase is None or log.cycle is None or log.step is None:
        return None
    playing = np.array([phase == "play" for phase in log.phase])
    if not playing.any():
        return None
    label = log.cycle[playing] * (rows + 1) + log.step[playing]
    _, first = np.unique(label, return_index=True)
    times = log.time_s[playing][first]
    due = log.cycle[playing][first] * (cycle_duration_s + pause_s)
    due = due + log.step[playing][first] * cycle_duration_s / rows
    return float(np.percentile(times - due, 5))


def start_by_shape(
    schedule: Schedule, time_s: Floats, measured: Floats, shown: Callable[[Floats], Floats] | None = None
) -> Offset | None:
    """t0 on the cameras' clock, by laying what is commanded over what was measured (servo lag goes into it).

    shown: what would be measured (R, .) of joint angles (R, m); default: themselves.
    """
    schedule, before = schedule.seen_in(float(np.ptp(time_s))), min(1.0, schedule.pause_s)
    grid = np.arange(-before, schedule.whole_s + before, schedule.cycle_duration_s / 200)
    told = schedule.commanded(grid + schedule.start_s)
    return find_offset(time_s, measured, grid, told if shown is None else shown(told))


def play_record(schedule: Schedule, rate_hz: float) -> tuple[Floats, list[tuple[str, int, int]]]:
    """Times from 0 and (phase, cycle, step) of a log sampled at `rate_hz`: for rehearsals."""
    times = np.arange(0.0, schedule.whole_s, 1.0 / rate_hz)
    rows = len(schedule.table)
    labels = []
    for time in times:
        cycle, since = int(time // schedule.period_s), time % schedule.period_s
        step = int(since / schedule.cycle_duration_s * rows)
        labels.append(("play", cycle, step) if step < rows else ("pause", cycle, rows))
    return times, labels
