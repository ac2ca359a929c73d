"""Frames that a camera lost while its count, and with it the film's clock, went on as if none were.

Log time is film time less a shift s: one for the whole film, or one that runs evenly (clocks with different rates), or
one until some moment and a smaller one after it; by the difference D seconds are missing there,

    cost(t0, D) = sum_{t < t0} e(t, s)^2 + sum_{t >= t0} e(t, s - D)^2,      e: the film's angles less the log's

The error's size is unknown on either side, as where clocks are laid over each other (`measure.clock`): evidence is
FREEDOM / 2 times the log of the ratio of costs, and losing frames as rare as what else is wrong.

Legend: R frames, K shifts, m joints.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from serpenoid.measure.cells import Floats, clock
from serpenoid.measure.clock import EARLY, FREEDOM, TINY, find_offset, interpolate
from serpenoid.measure.consistency.signals import LEAST_ROWS, Signal

MOST_ROWS = 400  # of the film are compared
REACH = 0.5  # periods: a shift beyond looks like a smaller one
SHIFTS = 81  # that are tried within
SLOPES = 41  # rates of the film's clock, up to the reach from one end to the other


@dataclass(frozen=True)
class Lost:
    """seconds of the film that are missing at a moment of its clock [s]."""

    at_s: float
    seconds: float

    @property
    def said(self) -> str:
        """What it means, and what to do."""
        return (
            f"about {self.seconds:.2g} s are missing from the film near {clock(round(self.at_s, 1))} s of its clock: "
            "the servo log goes on there. Did the camera lose frames and count on? Give the frames' own times, or "
            "leave one side out (`from_s`, `to_s`): clocks and motion across it are wrong"
        )


def lost_frames(cameras: Signal, servos: Signal) -> Lost | None:
    """Where frames are missing, if the film's clock is explained far better so than by one that runs evenly."""
    rows = np.flatnonzero(cameras.known)[:: max(1, int(cameras.known.sum() / MOST_ROWS))]
    time, seen = cameras.time_s[rows], cameras.values[rows]
    log_s, read = servos.time_s[servos.known], servos.values[servos.known]
    offset, period = find_offset(time, seen, log_s, read), servos.period_s
    if offset is None or period is None:
        return None
    shifts = offset.offset_s + np.linspace(-REACH, REACH, SHIFTS) * period
    costs = _costs(time, seen, log_s, read, shifts)
    inside = np.isfinite(costs).all(axis=0)
    if inside.sum() < 2 * LEAST_ROWS:
        return None
    time, costs = time[inside], costs[:, inside]
    even = min(float(costs.sum(axis=1).min()), _running(costs, time))
    cost, at, before, after = _stepped(costs)
    lost = float(shifts[before] - shifts[after])
    frame = float(np.median(np.diff(cameras.time_s)))
    gain = FREEDOM / 2 * np.log(even / max(cost, TINY))
    return Lost(float(time[at]), lost) if lost > frame and gain > np.log(1 / EARLY - 1) else None


def _costs(time: Floats, seen: Floats, log_s: Floats, read: Floats, shifts: Floats) -> Floats:
    """Squared errors (K, R), the constants of joints taken off; NaN where the log says nothing."""
    misses = np.stack([seen - interpolate(log_s + s, read, time) for s in shifts])
    zero = np.nanmedian(misses[len(shifts) // 2], axis=0)
    return np.asarray(((misses - zero) ** 2).sum(axis=2))


def _running(costs: Floats, time: Floats) -> float:
    """The least cost of a shift that runs evenly through the film."""
    count = len(costs)
    share = (time - time.mean()) / max(float(np.ptp(time)), TINY)
    best = np.inf
    for slope in np.linspace(-count / 2, count / 2, SLOPES):
        at = np.round(np.arange(count)[:, None] + slope * share).astype(int)
        within = ((at >= 0) & (at < count)).all(axis=1)
        if within.any():
            best = min(best, float(costs[at[within], np.arange(len(time))].sum(axis=1).min()))
    return best


def _stepped(costs: Floats) -> tuple[float, int, int, int]:
    """The least cost with one step, the row at which it is, and the shifts before and after."""
    before = np.cumsum(costs, axis=1)
    after = before[:, -1:] - before
    first, then = before[:, :-1].argmin(axis=0), after[:, :-1].argmin(axis=0)
    sums = before[:, :-1].min(axis=0) + after[:, :-1].min(axis=0)
    ends = slice(LEAST_ROWS - 1, len(sums) - LEAST_ROWS + 1)
    row = int(np.argmin(sums[ends])) + LEAST_ROWS - 1
    return float(sums[row]), row + 1, int(first[row]), int(then[row])
