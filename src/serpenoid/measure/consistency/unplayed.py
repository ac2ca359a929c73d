"""Cycles that were promised and not played, as a film shows that rests before the first and after the last of them, if
the servo log's readings do not go on meanwhile."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from serpenoid.measure.cells import Floats
from serpenoid.measure.consistency.hypotheses import ROLLS
from serpenoid.measure.consistency.signals import Signal, stopped_s
from serpenoid.measure.logs import ServoLog
from serpenoid.measure.schedule import Schedule
from serpenoid.wording import counted

BEGUN = 0.25  # of a period: what is moved longer than its cycles by, as servos that lag come to rest


def as_filmed(schedule: Schedule, time_s: Floats, angles: Floats, log: ServoLog | None = None) -> Schedule:
    """With no more cycles than joint angles (F, m), NaN unknown, move for, where a film shows that they rest before,
    and afterwards for longer than in a pause; as it is where fewer cannot be told from a film that is cut, and with as
    many as servos read that they moved for."""
    signal = Signal(time_s, angles)
    if not signal.enough:
        return schedule
    moved_s, end_s = stopped_s(signal)
    known_s, clear = signal.time_s[signal.known], schedule.cycle_duration_s / ROLLS
    begun, rested = end_s - moved_s - known_s[0], known_s[-1] - end_s
    if begun < clear or rested < schedule.pause_s + clear:
        return schedule
    read = None if log is None else Signal(log.time_s, log.position)
    if read is not None and read.enough:
        moved_s = max(moved_s, stopped_s(read)[0])
    played = max(1, int(np.ceil((moved_s + schedule.pause_s) / schedule.period_s - BEGUN)))
    return replace(schedule, cycles=min(schedule.cycles, played))


def unplayed(promised: int, played: int) -> str:
    """What to say of cycles that were promised and not played."""
    return (
        f"the film shows {counted(played, 'cycle')}, with rests before and after, where `cycles = {promised}` are "
        f"promised: {played} are used"
    )
