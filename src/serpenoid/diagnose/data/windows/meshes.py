"""Time meshes of trials: rows at which shapes are asked for, and the boundaries of windows among them.

A cycle is cut into windows, each into equal steps, and a pause into two. A body that coasts into a pause is slowed by
drag: at first as quickly as while it played, and quadratic drag slows it by one share in steps that grow in proportion
to the time since then. So steps of a pause begin with those of the cycle, and each is longer than the one before.

Where a table's rows are held, servos jump and rest: between two rows that are due, steps are as long as is even in time
t and in what joints bend by,

    s(t) = t / T + w(t) / w(T),   w(t) = int |q'| dt,

so that no step cuts the corner of two jumps, and a jump is followed however short it is.

Legend: R rows, B boundaries.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.recordings.recording import WINDOWS_PER_CYCLE, Recording
from serpenoid.measure.schedule import Schedule

COARSER = 8  # fits take every eighth row; what that changes is known from the guiding model, and put back
STEPS_PER_WINDOW = 9 * COARSER  # fits have 72 steps a cycle, which may be longer than momentum lasts
LEAST_PER_HALF = 4 * COARSER  # steps of either half of a pause
GROWTH = 1.2  # of a fit's step in a pause over the one before
LEAST_PER_ROW = 2 * COARSER  # steps from a row that is due to the next
BENDING = 64  # parts of such a stretch in which it is measured how joints bend


@dataclass(frozen=True)
class Mesh:
    """Rows (R,) [s], boundaries (B,) among them; playing, cycle and phase of each window (B - 1,); breaks: rows (K,)
    at which the rate may jump, 0 and the last among them; followed: whether steps follow rows that are held."""

    time: Floats
    bounds: np.ndarray
    playing: np.ndarray
    cycle: np.ndarray
    phase: Floats
    breaks: np.ndarray
    followed: bool = False


def mesh_of(r: Recording) -> Mesh:
    """Of what both schedule and cameras cover."""
    even = _even(r)
    jumps = _jumps(r.schedule, float(even.time[-1])) if r.schedule.held else np.empty(0)
    return _followed(r, even, jumps) if len(jumps) else even


def _even(r: Recording) -> Mesh:
    """In equal steps while playing, and steps that grow in pauses."""
    s = r.schedule
    time, bounds, playing, cycle, phase, turns = [np.zeros(1)], [0], [], [], [], [0]
    play, resting = WINDOWS_PER_CYCLE * STEPS_PER_WINDOW, _resting(s)
    for n in range(s.cycles):
        start = n * s.period_s
        time.append(start + np.arange(1, play + 1) / play * s.cycle_duration_s)
        bounds += [bounds[-1] + STEPS_PER_WINDOW * (i + 1) for i in range(WINDOWS_PER_CYCLE)]
        playing += [True] * WINDOWS_PER_CYCLE
        phase += [(i + 0.5) / WINDOWS_PER_CYCLE for i in range(WINDOWS_PER_CYCLE)]
        cycle += [n] * WINDOWS_PER_CYCLE
        turns.append(bounds[-1])
        if s.pause_s > 0:
            time += [start + s.cycle_duration_s + half for half in resting]
            bounds += (bounds[-1] + np.cumsum([len(half) for half in resting])).tolist()
            playing += [False] * 2
            phase += [1.0] * 2
            cycle += [n] * 2
            turns.append(bounds[-1])
    rows = np.concatenate(time)
    last = int(np.searchsorted(rows[bounds], r.end + 1e-6))
    keep, cut = np.array(bounds[:last]), slice(None, last - 1)
    breaks = np.array([*(b for b in turns if b < keep[-1]), keep[-1]])
    windows = np.array(playing)[cut], np.array(cycle)[cut], np.array(phase, dtype=float)[cut]
    return Mesh(rows[: keep[-1] + 1], keep, *windows, breaks)


def _resting(s: Schedule) -> list[Floats]:
    """Rows of both halves of a pause [s], since it began: a fit's first step is as long as in a cycle, and each is
    GROWTH times the one before, in the second half, too. A half has LEAST_PER_HALF rows or more; where as many steps
    need not grow, they are equal."""
    half, first = s.pause_s / 2, s.cycle_duration_s / (WINDOWS_PER_CYCLE * STEPS_PER_WINDOW // COARSER)
    halves, begin = [], first
    for before in (0.0, half):
        count = max(LEAST_PER_HALF // COARSER, int(np.ceil(np.log1p(half / begin * (GROWTH - 1)) / np.log(GROWTH))))
        ratio = GROWTH if half > count * begin else 1.0
        grown = np.cumsum(ratio ** np.repeat(np.arange(count), COARSER))
        halves.append(before + grown / grown[-1] * half)
        begin *= ratio**count
    return halves


def _jumps(s: Schedule, end: float) -> Floats:
    """Times at which held rows are due, up to an end [s]; none where there are more than two in a step of a fit: these
    jumps are no larger than what is moved in one."""
    rows = len(s.table)
    if rows * COARSER > 2 * WINDOWS_PER_CYCLE * STEPS_PER_WINDOW:
        return np.empty(0)
    due = np.arange(s.cycles)[:, None] * s.period_s + np.arange(rows + 1) / rows * s.cycle_duration_s
    return np.asarray(due[due < end])


def _followed(r: Recording, even: Mesh, jumps: Floats) -> Mesh:
    """Its boundaries, and steps that follow every jump."""
    ends, breaks = even.time[even.bounds], np.concatenate([jumps, even.time[even.breaks]])
    every = np.unique(np.round(np.concatenate([ends, breaks]), 9))
    time = [every[:1], *(_steps(r, even.time, a, b) for a, b in zip(every[:-1], every[1:], strict=True))]
    rows = np.concatenate(time)
    at = [np.searchsorted(rows, np.unique(np.round(t, 9))) for t in (ends, breaks)]
    return Mesh(rows, at[0], even.playing, even.cycle, even.phase, at[1], followed=True)


def _steps(r: Recording, usual: Floats, begin: float, end: float) -> Floats:
    """Rows from after a time to another [s], no fewer than the usual ones."""
    time = begin + (end - begin) * np.arange(BENDING + 1) / BENDING
    share = evenly(r, time)
    count = np.searchsorted(usual, [begin, end])
    steps = max(LEAST_PER_ROW, COARSER * int(np.ceil((count[1] - count[0]) / COARSER)))
    found = np.interp(np.arange(1, steps + 1) / steps * share[-1], share, time)
    found[-1] = end
    return found


def evenly(r: Recording, time: Floats) -> Floats:
    """s at times (R,): 0 at the first, 2 at the last, 1 where no joint bends."""
    bent = np.concatenate([[0.0], np.linalg.norm(np.diff(r.angles_at(time), axis=0), axis=1).cumsum()])
    return np.asarray((time - time[0]) / (time[-1] - time[0]) + bent / max(float(bent[-1]), 1e-12))
