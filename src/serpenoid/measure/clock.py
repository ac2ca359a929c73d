"""Clocks without a common zero: the offset that lays one signal best over another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from serpenoid.measure.cells import Floats

GRID_S = 0.04  # search grid: far finer than a gait cycle; the best shift is refined afterwards
FINE_S = GRID_S * np.linspace(-3, 3, 13)  # about a shift at which ends are held, which draws it aside
MOST_S = 2e5  # of two records: beyond two days a clock was set meanwhile, and their grids do not fit into memory
MOST_ROWS = 10_000  # of a record that choose between shifts; the best is then refined on all
MOST_SHIFTS = 40  # that nearly agree
FREEDOM = 4.0  # numbers in which two records differ: amplitudes and phases of two harmonics
TINY = 1e-300  # of two signals that agree to the last bit
CUT_S = 0.1  # in which a record at its end moves, or rests, unless its noise asks for longer
LEAST_STRETCHES = 8  # of a record: fewer do not tell where it moves
EARLY = 0.05  # of logs end early: as rare as what else is wrong (`consistency.rivals.FAULTY`)
LEAST_COMMON = 4  # rows of two records: fewer are no overlap
ROBUST = 1.4826  # SD over median distance from the median, of normal numbers
HOLE = 3.0  # typical frames: a longer gap is not bridged


@dataclass(frozen=True)
class Offset:
    """Reference clock = other clock + offset_s. `correlation` of the signals there, `rms` of their difference."""

    offset_s: float
    correlation: float
    rms: float


def interpolate(time_s: Floats, values: Floats, at_s: Floats) -> Floats:
    """Columns of `values` (R, m) at other times; NaN outside the record."""
    columns = [np.interp(at_s, time_s, column, left=np.nan, right=np.nan) for column in values.T]
    return np.stack(columns, axis=1)


def interpolate_smoothly(time_s: Floats, values: Floats, at_s: Floats) -> Floats:
    """The same by cubics that have the slope from the row before to the row after; nearly straight across holes.

    Straight lines between rows would cut the amplitude of what swings, by (omega dt)^2 / 12 on average.
    """
    if len(time_s) < 2:
        return interpolate(time_s, values, at_s)
    from scipy.interpolate import PPoly  # takes long to import, and a film without a log needs it not

    step, rows = np.diff(time_s)[:, None], np.arange(len(time_s))
    after, before = np.minimum(rows + 1, rows[-1]), np.maximum(rows - 1, 0)
    slope = (values[after] - values[before]) / (time_s[after] - time_s[before])[:, None]
    left, right, chord = slope[:-1], slope[1:], np.diff(values, axis=0) / step
    powers = [(left + right - 2 * chord) / step**2, (3 * chord - 2 * left - right) / step, left, values[:-1]]
    return np.asarray(PPoly(np.stack(powers), time_s, extrapolate=False)(at_s))


def bridged(time_s: Floats, values: Floats, at_s: Floats | None = None) -> Floats:
    """Columns of `values` (R, m), NaN unknown, at other times, else at their own: straight across holes, ends held; 0
    where nothing of a column is known."""
    at_s = time_s if at_s is None else at_s
    columns = []
    for column in values.T:
        known = np.isfinite(column)
        columns.append(np.interp(at_s, time_s[known], column[known]) if known.any() else np.zeros(len(at_s)))
    return np.stack(columns, axis=1)


def unwrapped(angles: Floats) -> Floats:
    """Columns of `angles` (R, m), NaN unknown, without jumps by a whole turn from one known row to the next."""
    straight = angles.copy()
    for column in straight.T:
        known = np.isfinite(column)
        column[known] = np.unwrap(column[known])
    return straight


def held(time_s: Floats, values: Floats, at_s: Floats) -> Floats:
    """All columns of `values` (R, m) at other times, linear in between; the ends are held outside the record."""
    right = np.clip(np.searchsorted(time_s, at_s), 1, len(time_s) - 1)
    share = np.clip((at_s - time_s[right - 1]) / (time_s[right] - time_s[right - 1]), 0.0, 1.0)
    before = values[right - 1]
    return np.asarray(before + share[:, None] * (values[right] - before))


def find_offset(reference_s: Floats, reference: Floats, other_s: Floats, other: Floats) -> Offset | None:
    """Offset that minimises the mean square difference of two signals (R, m), their means taken off; None: no overlap.

    Every shift that leaves half of the shorter record in common is tried. Beyond its ends the other signal is held: a
    robot stands still before it is played and after, and so a periodic gait is not mistaken by a whole cycle.
    """
    keep = np.isfinite(reference).all(axis=1)
    t, signal = reference_s[keep], reference[keep]
    if len(t) < 8 or len(other_s) < 8 or signal.std() == 0 or other.std() == 0:
        return None
    spans = t[-1] - t[0], other_s[-1] - other_s[0]
    if sum(spans) > MOST_S:
        return None
    half = 0.5 * min(spans)
    from scipy.optimize import minimize_scalar  # reading needs neither, and takes no longer than their import

    low, high = t[0] - other_s[-1] + half, t[-1] - other_s[0] - half
    coarse_t = np.arange(t[0], t[-1], GRID_S)
    coarse = held(t, signal, coarse_t)  # by rounding the grid's last time may lie behind the record's
    shifts = np.arange(low, high + GRID_S, GRID_S)
    costs = _held_costs(len(shifts), low, coarse_t, coarse, _seen(t, coarse_t), other_s, other)
    some = slice(None, None, max(1, len(t) // MOST_ROWS))
    best = _not_held(shifts, costs, t[some], signal[some], other_s, other)
    # about the best shift: a bounded search ends within 1e-8 of its argument, 18 s of a clock that counts from 1970
    found = minimize_scalar(
        lambda more: _cost(best + more, t, signal, other_s, other), bounds=(-GRID_S, GRID_S), method="bounded",
        options={"xatol": 1e-6},
    )  # fmt: skip
    shift = float(best + found.x)
    a, b = _common(shift, t, signal, other_s, other)
    if len(a) < LEAST_COMMON:
        return None
    scale = np.sqrt((a**2).sum() * (b**2).sum())
    correlation = float((a * b).sum() / scale) if scale > 0 else 0.0
    return Offset(shift, correlation, float(np.sqrt(np.mean((a - b) ** 2))))


def _not_held(shifts: Floats, costs: Floats, t: Floats, signal: Floats, other_s: Floats, other: Floats) -> float:
    """The best of `shifts`; another at which the signals agree far better where both are there, if there is one.

    A log that ends early (its battery dies) is not held where it ends; one that is as long as the motion, at rest at
    both ends, is whole. The error's size is unknown on either side: log evidence = -FREEDOM / 2 log(mean square
    difference), columns counted as one.
    """
    best = int(np.argmin(costs))
    if not is_cut(t, signal, other_s, other):
        return float(shifts[best])
    inner = 1 + np.flatnonzero((costs[1:-1] <= costs[:-2]) & (costs[1:-1] <= costs[2:]))
    some = np.unique([best, *inner[np.argsort(costs[inner], kind="stable")][:MOST_SHIFTS]])
    left = {
        (_cost(shift, t, signal, other_s, other), float(shift), k)
        for k in some.tolist()
        for shift in shifts[k] + FINE_S
    }
    own, (cost, shift, _) = min(c for c, _, k in left if k == best), min(left)
    return shift if far_likelier(cost, own) else float(shifts[best])


def as_likely(
    found: Offset, period_s: float, reference_s: Floats, reference: Floats, other_s: Floats, other: Floats
) -> list[float]:
    """Offsets whole periods away from the one found at which two signals (R, m) agree about as well, half of the
    shorter record in common, where the other is cut; none where it is whole, for then its ends tell."""
    if not is_cut(reference_s, reference, other_s, other):
        return []
    keep = np.isfinite(reference).all(axis=1)
    t, signal = reference_s[keep], reference[keep]
    half = 0.5 * min(t[-1] - t[0], other_s[-1] - other_s[0])
    low, high = t[0] - other_s[-1] + half, t[-1] - other_s[0] - half
    first, last = np.ceil((low - found.offset_s) / period_s), np.floor((high - found.offset_s) / period_s)
    own, likely = _cost(found.offset_s, t, signal, other_s, other), []
    for shift in found.offset_s + period_s * np.arange(first, last + 1):
        cost, best = min((_cost(at, t, signal, other_s, other), float(at)) for at in shift + FINE_S)
        if abs(shift - found.offset_s) > period_s / 2 and not far_likelier(own, cost):
            likely.append(best)
    return likely


def far_likelier(cost: float, other: float) -> bool:
    """Whether a mean square difference explains so much more than another as what is as rare as a short log must."""
    return bool(FREEDOM / 2 * np.log(max(other, TINY) / max(cost, TINY)) > np.log(1 / EARLY - 1))


def is_cut(reference_s: Floats, reference: Floats, other_s: Floats, other: Floats) -> bool:
    """Whether the other record (R, m) is shorter than the motion that the first shows, or begins or ends amid it."""
    keep = np.isfinite(reference).all(axis=1)
    begin, quick = _quick(reference_s[keep], reference[keep])
    span = begin[quick][-1] - begin[quick][0]
    own = _moving(other_s, other)
    return bool(own[0] or own[-1] or other_s[-1] - other_s[0] < span)


def _moving(time_s: Floats, values: Floats) -> NDArray[np.bool_]:
    """In which stretches a record without noise (R, m), that of servos, moves no less than in the root mean square."""
    moved = _squared_steps(held(time_s, values, _stretches(time_s, CUT_S, fewest=1)))
    return np.asarray(moved >= moved.mean())


def _quick(time_s: Floats, values: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """When stretches of a film's record (R, m) begin [s], and between which and the next, by their means, it moves no
    less than in the root mean square.

    Where noise moves these as far as the motion does, a record at rest would seem to move: stretches are then twice as
    long, and so on, down to LEAST_STRETCHES.
    """
    covariance, stretch_s = _white(values), CUT_S
    while True:
        edges = _stretches(time_s, stretch_s, fewest=2)
        means, frames = _means(time_s, values, edges)
        moved = _squared_steps(means)
        noise = _by_noise(covariance, len(moved)) * (1 / frames[:-1] + 1 / frames[1:])
        if len(frames) < 2 * LEAST_STRETCHES or moved.mean() >= noise.mean():
            return edges[:-2], moved >= moved.mean()
        stretch_s *= 2


def _stretches(time_s: Floats, stretch_s: float, fewest: int) -> Floats:
    """Edges (n + 1,) of n stretches of equal length, about as long as asked for, that make up a record."""
    span = time_s[-1] - time_s[0]
    return np.linspace(time_s[0], time_s[-1], max(int(span / stretch_s), fewest) + 1)


def _squared_steps(rows: Floats) -> Floats:
    """Squared distance (R - 1,) from each row of (R, m) to the next."""
    return np.asarray((np.diff(rows, axis=0) ** 2).sum(axis=1))


def _means(time_s: Floats, values: Floats, edges: Floats) -> tuple[Floats, Floats]:
    """Of a record (R, m) between evenly spaced times, and of how many frames each; where there are none, the record
    between its frames, as of one."""
    count = len(edges) - 1
    within = np.minimum(((time_s - edges[0]) / (edges[1] - edges[0])).astype(int), count - 1)
    frames = np.bincount(within, minlength=count).astype(float)
    sums = np.stack([np.bincount(within, column, count) for column in values.T], axis=1)
    between = held(time_s, values, (edges[:-1] + edges[1:]) / 2)
    most = np.maximum(frames, 1)
    return np.where(frames[:, None] > 0, sums / most[:, None], between), most


def _white(values: Floats) -> Floats:
    """Covariance (m, m) of the noise of a record's rows: of third differences, which motion hardly has, over 20."""
    third = np.diff(values, n=3, axis=0)
    return third.T @ third / (20 * max(len(third), 1))


def _by_noise(covariance: Floats, count: int) -> float:
    """Square that the sum of noise of this covariance stays below in all of `count` rows but with chance EARLY.

    A sum of squares of correlated numbers is as one of fewer that are alike (Satterthwaite).
    """
    from scipy.special import chdtri

    total, squares = float(np.trace(covariance)), float((covariance**2).sum())
    if not squares > 0:
        return 0.0
    alike = total**2 / squares
    return total * float(chdtri(alike, EARLY / count)) / alike


def _held_costs(
    count: int, low: float, t: Floats, signal: Floats, seen: NDArray[np.bool_], other_s: Floats, other: Floats
) -> Floats:
    """Of the shifts low, low + GRID_S, ..: sums over one grid, for `t` has the same step, as correlations.

    cost_k = sum (signal - laid_k)^2 - (sum signal - laid_k)^2 / n over what is seen, laid_k the other signal there.
    """
    from scipy.fft import irfft, next_fast_len, rfft

    first = t[0] - low - GRID_S * (count - 1)
    laid = held(other_s, other, first + GRID_S * np.arange(count - 1 + len(t)))
    laid, there = laid - laid.mean(axis=0), seen.astype(float)[:, None]
    own = (signal - signal[seen].mean(axis=0)) * there
    length = next_fast_len(len(laid), real=True)

    def summed(weights: Floats, values: Floats) -> Floats:
        """sum_i weights[i] values[k + i], the last k first, shape (count, m)."""
        product = rfft(values, length, axis=0) * np.conj(rfft(weights, length, axis=0))
        return np.asarray(irfft(product, length, axis=0))[:count][::-1]

    squares = (own**2).sum(axis=0) - 2 * summed(own, laid) + summed(there, laid**2)
    sums = own.sum(axis=0) - summed(there, laid)
    return np.asarray((squares - sums**2 / seen.sum()).sum(axis=1))


def _seen(t: Floats, grid: Floats) -> NDArray[np.bool_]:
    """Which of a grid lie in no hole of the record: a straight line across half a cycle is like no motion."""
    gaps = np.diff(t)
    around = gaps[np.clip(np.searchsorted(t, grid) - 1, 0, len(gaps) - 1)]
    return np.asarray(around <= max(GRID_S, HOLE * float(np.median(gaps))))


def _common(shift: float, t: Floats, signal: Floats, other_s: Floats, other: Floats) -> tuple[Floats, Floats]:
    moved = interpolate(other_s + shift, other, t)
    both = np.isfinite(moved).all(axis=1)
    a, b = signal[both], moved[both]
    return (a - a.mean(axis=0), b - b.mean(axis=0)) if both.any() else (a, b)


def _cost(shift: float, t: Floats, signal: Floats, other_s: Floats, other: Floats) -> float:
    a, b = _common(shift, t, signal, other_s, other)
    return float(((a - b) ** 2).mean()) if len(a) >= LEAST_COMMON else np.inf
