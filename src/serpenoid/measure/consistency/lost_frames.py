"""Frames that a camera lost while its count, and with it the film's clock, went on as if none were.

Log time is film time less a shift s: one for the whole film, or one that runs evenly (clocks with different rates), or
one that is smaller after some moments t_i: by the differences D_i seconds are missing there,

    cost(t_i, D_i) = sum e(t, s - sum_i D_i [t >= t_i])^2,      e: the film's angles less the log's

The error's size is unknown on either side, as where clocks are laid over each other (`measure.clock`): evidence is
FREEDOM / 2 times the log of the ratio of costs, and losing frames once as rare as what else is wrong. How long is
missing is then fitted to all frames, together with a shift and a rate of the clocks:

    log time = film time less (shift + rate film time - sum_i D_i [film time >= t_i])

Legend: R frames, K shifts, m joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from serpenoid.measure.cells import Floats, clock
from serpenoid.measure.clock import EARLY, FREEDOM, ROBUST, TINY, find_offset, interpolate
from serpenoid.measure.consistency.signals import LEAST_ROWS, Signal

MOST_ROWS = 400  # of the film are compared
REACH = 0.5  # periods: a shift beyond looks like a smaller one
SHIFTS = 81  # that are tried within
SLOPES = 41  # rates of the film's clock, up to the reach from one end to the other
MOST_PLACES = 4  # that are looked for
ITERATIONS = 4  # of the fit: from a grid's step to what noise leaves open
OUTLYING = 5.0  # robust standard deviations

Step = tuple[int, int, int]  # the row after it, the shifts before and after


@dataclass(frozen=True)
class Lost:
    """seconds of the film that are missing at a moment of its clock [s]."""

    at_s: float
    seconds: float

    @property
    def said(self) -> str:
        """What it means, what was done, and what to do."""
        return (
            f"about {self.seconds:.2g} s are missing from the film near {clock(round(self.at_s, 1))} s of its clock: "
            "the servo log goes on there. Did the camera lose frames and count on? Its clock is set on by so much "
            "there. Give the frames' own times, or, if the film is whole, set `believe = true` in the trial"
        )


def lost_frames(cameras: Signal, servos: Signal) -> tuple[Lost, ...]:
    """Wherever frames are missing, if the film's clock is explained far better so than by one that runs evenly."""
    rows = np.flatnonzero(cameras.known)[:: max(1, int(cameras.known.sum() / MOST_ROWS))]
    time, seen = cameras.time_s[rows], cameras.values[rows]
    log_s, read = servos.time_s[servos.known], servos.values[servos.known]
    offset, period = find_offset(time, seen, log_s, read), servos.period_s
    if offset is None or period is None:
        return ()
    shifts = offset.offset_s + np.linspace(-REACH, REACH, SHIFTS) * period
    costs = _costs(time, seen, log_s, read, shifts)
    inside = np.isfinite(costs).all(axis=0)
    if inside.sum() < 2 * LEAST_ROWS:
        return ()
    rows, costs = rows[inside], costs[:, inside]
    if _evidence(float(costs.sum(axis=1).min()), float(costs.min(axis=0).sum()), 1) <= 0:
        return ()  # whatever the places, no row costs less than by the best of all shifts
    even = min(float(costs.sum(axis=1).min()), _running(costs, time[inside]))
    best, found = 0.0, list[Step]()
    for steps in _stepped(costs, MOST_PLACES):
        cost = float(costs[_ways(steps, len(rows)), np.arange(len(rows))].sum())
        gain = _evidence(even, cost, len(steps))
        if gain > best:
            best, found = gain, steps
    frame, rough = float(np.median(np.diff(cameras.time_s))), list[Lost]()
    for at, before, after in found:
        lost = float(shifts[before] - shifts[after])
        between = rows[[max(at - 2, 0), min(at + 1, len(rows) - 1)]]
        if lost > frame:
            place = _frame(cameras, log_s, read, shifts[[before, after]], between)
            rough.append(Lost(float(cameras.time_s[place]), lost))
    return _fitted(cameras, servos, rough) if rough else ()


def _evidence(even: float, cost: float, places: int) -> float:
    """By how much frames lost at so many places are likelier than none [nats], by the costs of both."""
    return float(FREEDOM / 2 * np.log(even / max(cost, TINY)) - places * np.log(1 / EARLY - 1))


def set_on(time_s: Floats, found: Sequence[Lost]) -> Floats:
    """Times of frames (R,) with the seconds that are missing before each."""
    return np.asarray(time_s + sum((one.seconds * (time_s >= one.at_s) for one in found), np.zeros(len(time_s))))


def _frame(cameras: Signal, log_s: Floats, read: Floats, shifts: Floats, between: NDArray[np.int64]) -> int:
    """The first frame after a place that is known to lie between two, by the shifts before and after."""
    rows = np.flatnonzero(cameras.known)
    ways = _costs(cameras.time_s[rows], cameras.values[rows], log_s, read, shifts)
    near = (rows >= between[0]) & (rows <= between[1]) & np.isfinite(ways).all(axis=0)
    before, after = np.cumsum(ways[:, near], axis=1)
    return int(rows[near][1 + np.argmin((before - after)[:-1])])


def _fitted(cameras: Signal, servos: Signal, rough: Sequence[Lost]) -> tuple[Lost, ...]:
    """The same places with their seconds, by least squares over all frames."""
    time, seen = cameras.time_s[cameras.known], cameras.values[cameras.known]
    log_s, read = servos.time_s[servos.known], servos.values[servos.known]
    offset = find_offset(set_on(time, rough), seen, log_s, read)
    if offset is None:
        return tuple(rough)
    rising = np.gradient(read, log_s, axis=0)
    later = np.stack([np.ones(len(time)), time - time.mean(), *(-1.0 * (time >= one.at_s) for one in rough)])
    numbers = np.array([offset.offset_s, 0.0, *(one.seconds for one in rough)])
    for _ in range(ITERATIONS):
        at = time - numbers @ later
        miss, speed = seen - interpolate(log_s, read, at), interpolate(log_s, rising, at)
        miss = miss - np.nanmedian(miss, axis=0)
        use = np.isfinite(miss) & (np.abs(miss) <= OUTLYING * ROBUST * np.nanmedian(np.abs(miss)))
        columns = (-later[:, :, None] * np.where(use, speed, 0.0)).reshape(len(later), -1)
        numbers = numbers + np.linalg.lstsq(columns.T, np.where(use, miss, 0.0).ravel(), rcond=None)[0]
    return tuple(Lost(one.at_s, float(s)) for one, s in zip(rough, numbers[2:], strict=True))


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


def _stepped(costs: Floats, most: int) -> list[list[Step]]:
    """For one step and more, up to so many: the places and shifts that cost least, every shift below the one before."""
    count, rows = costs.shape
    stay, found = np.cumsum(costs, axis=1).T, list[list[Step]]()  # (R, K): the least cost of rows so far
    history: list[tuple[NDArray[np.bool_], NDArray[np.int64]]] = []
    for _ in range(most):
        moved, stepped = np.full((rows, count), np.inf), np.zeros((rows, count), dtype=bool)
        above = np.zeros((rows, count), dtype=int)
        for row in range(LEAST_ROWS, rows):
            moved[row] = moved[row - 1] + costs[:, row]
            if row <= rows - LEAST_ROWS:
                least, above[row] = _least_above(stay[row - 1])
                stepped[row] = least + costs[:, row] < moved[row]
                moved[row] = np.minimum(moved[row], least + costs[:, row])
        if not np.isfinite(moved[-1]).any():
            break
        history.append((stepped, above))
        found.append(_traced(history, int(np.argmin(moved[-1])), rows))
        stay = moved
    return found


def _least_above(values: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """The least of all later values (K,), and where it is; the last has none."""
    from_end = np.append(values[1:], np.inf)[::-1]
    best = np.minimum.accumulate(from_end)
    where = np.maximum.accumulate(np.where(from_end == best, np.arange(len(values)), 0))
    return best[::-1], np.minimum(len(values) - where[::-1], len(values) - 1)


def _traced(history: Sequence[tuple[NDArray[np.bool_], NDArray[np.int64]]], shift: int, rows: int) -> list[Step]:
    """From the last row back to every step."""
    found, row = list[Step](), rows - 1
    for stepped, above in reversed(history):
        row = int(np.flatnonzero(stepped[: row + 1, shift])[-1])
        before = int(above[row, shift])
        found, shift, row = [(row, before, shift), *found], before, row - 1
    return found


def _ways(steps: Sequence[Step], rows: int) -> NDArray[np.int64]:
    """The shift of every row (R,)."""
    way = np.full(rows, steps[0][1])
    for row, _, after in steps:
        way[row:] = after
    return way
