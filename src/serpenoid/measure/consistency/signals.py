"""Joint angles over time from one witness (cameras, servos, commands), on an even grid, with their noise and period.

Legend: R rows as recorded, n grid points, m joints.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft
from scipy.special import ndtri

from serpenoid.measure.cells import Floats
from serpenoid.measure.clock import ROBUST, held

MOST_POINTS = 4000  # of a grid: a hundred cycles at 40 points
LEAST_ROWS = 8  # that can be laid over anything
MOVING = 4.0  # times the noise's variance: with few rows motion must be as clear
ALIKE = 0.25  # of its variance that a row shares with the next: two witnesses of such motion correlate by 0.5
ROUNDING = 1e-12  # rad^2: of numbers that never change
CHANCE = 0.01  # of witnesses whose rows are in disorder that are taken for motion: stated
AWAY = 0.1  # of the motion's size: it has begun, or has not ended
LEAST_OVERLAP = 1 / 3  # of the motion's sum of squares: a cycle and a half, two whatever the pause
NEAR_PERIOD = 0.06  # of a period: rests that overlap draw its first estimate aside by less
AGREES = 0.5  # with itself a period later, of its variance: with less, nothing repeats
REPEATING = 0.9  # of the best agreement with itself: the first such delay is the period, later ones its multiples


@dataclass(frozen=True)
class Signal:
    """What a witness says of the joint angles (R, m) [rad] at times (R,) [s]; NaN where it does not know."""

    time_s: Floats
    values: Floats

    @cached_property
    def enough(self) -> bool:
        """Whether it can be laid over anything: it moves, and known rows are near enough to each other."""
        if self.known.sum() < LEAST_ROWS or not self.moves:
            return False
        return bool(sample(self, float(np.median(np.diff(self.time_s)))).weight.sum() >= LEAST_ROWS)

    @cached_property
    def known(self) -> NDArray[np.bool_]:
        """Rows (R,) in which every joint's angle is there."""
        return np.asarray(np.isfinite(self.values).all(axis=1))

    @property
    def moves(self) -> bool:
        """Whether any joint varies by more than its own noise does by chance: in size, or alike from row to row.

        What a row in disorder shares with the next, over its variance, is normal: 0, give or take 1 / sqrt(rows).
        """
        whole = self.values[self.known]
        if len(whole) < 2:
            return False
        away = whole - whole.mean(axis=0)
        size, shared = (away**2).mean(axis=0), (away[1:] * away[:-1]).mean(axis=0)
        alike = shared > max(ALIKE, ndtri(1 - CHANCE / len(size)) / np.sqrt(len(whole))) * size
        return bool((alike & (size > ROUNDING) | (size > MOVING * self.noise_variance)).any())

    @cached_property
    def noise_variance(self) -> Floats:
        """White noise of every joint (m,) [rad^2], from second differences: mean (a - 2 b + c)^2 / 6, by medians."""
        bend = np.diff(self.values, n=2, axis=0)
        bend = bend[np.isfinite(bend).all(axis=1)]
        if len(bend) < LEAST_ROWS:
            return np.full(self.values.shape[1], 1e-8)
        return np.asarray((ROBUST * np.median(np.abs(bend), axis=0)) ** 2 / 6 + ROUNDING)

    @cached_property
    def period_s(self) -> float | None:
        """After what time it repeats: the first delay at which it agrees with itself nearly best; None: never."""
        return _period_s(self)

    @property
    def repeats_s(self) -> float | None:
        """The same between frames: where what lies as much later is most like it [s]."""
        return None if self.period_s is None else _likest(self, self.period_s)


@dataclass(frozen=True)
class Sampled:
    """The same on an even grid: values (n, m), zero where nothing is known; weight (n,) 0 or 1."""

    start_s: float
    step_s: float
    values: Floats
    weight: Floats
    noise_variance: Floats

    @property
    def span_s(self) -> float:
        return self.step_s * (len(self.values) - 1)

    @cached_property
    def mean(self) -> Floats:
        """Of every joint over the known rows (m,)."""
        return np.asarray((self.weight @ self.values) / self.weight.sum())

    @cached_property
    def spread(self) -> Floats:
        """Variance of every joint over the known rows (m,)."""
        return np.asarray(self.weight @ (self.values - self.mean) ** 2 / self.weight.sum())

    def transforms(self, size: int) -> Floats:
        """Conjugate Fourier transforms of the weight and of the values (size / 2 + 1, 1 + m), zeros after them."""
        if size not in self._transforms:
            self._transforms[size] = np.conj(rfft(np.column_stack([self.weight, self.values]), size, axis=0))
        return self._transforms[size]

    @cached_property
    def _transforms(self) -> dict[int, Floats]:
        return {}


def sample(signal: Signal, step_s: float, begin_s: float | None = None, end_s: float | None = None) -> Sampled:
    """On a grid of `step_s`, linear between known rows; weight 0 inside gaps longer than two steps and three rows."""
    time, values = signal.time_s[signal.known], signal.values[signal.known]
    begin, end = max(begin_s or -np.inf, time[0]), min(end_s or np.inf, time[-1])
    step = max(step_s, (end - begin) / MOST_POINTS)
    at = begin + step * np.arange(int((end - begin) / step) + 1)
    right = np.clip(np.searchsorted(time, at), 1, len(time) - 1)
    longest = max(2 * step, 3 * float(np.median(np.diff(signal.time_s))))
    weight = (time[right] - time[right - 1] <= longest).astype(float)
    grid = held(time, values, at)
    return Sampled(float(begin), float(step), grid * weight[:, None], weight, signal.noise_variance)


def _by_frames(signal: Signal) -> Sampled:
    """On a grid as close as its frames."""
    return sample(signal, float(np.median(np.diff(signal.time_s))))


def _without_outliers(values: Floats) -> Floats:
    """Columns about their medians, cut at four robust standard deviations: bad frames do not repeat.

    Where most rows rest in a pause there is none; twice what nine rows in ten stay within, then.
    """
    away = values - np.median(values, axis=0)
    robust, wide = 4 * ROBUST * np.median(np.abs(away), axis=0), 2 * np.quantile(np.abs(away), 0.9, axis=0)
    limit = np.where(robust > wide / 4, robust, wide)
    clipped = np.clip(away, -limit, limit)
    return np.asarray(clipped - clipped.mean(axis=0))


def _period_s(signal: Signal) -> float | None:
    """The first delay at which it agrees with itself nearly best: products over squares of all that overlaps, while
    that is a third of all its motion: of its squares about where it rested, since what rests in a pause does not move;
    of rows in holes no more is asked than they are in all."""
    whole = _between_rests(_by_frames(signal))
    centred = _without_outliers(whole.values) * whole.weight[:, None]
    squares, count = (centred**2).sum(axis=1), len(centred)
    if not squares.sum() > 0:  # between holes that are too long nothing varies
        return None
    away = ((centred - np.median(centred[whole.weight > 0][:5], axis=0)) ** 2).sum(axis=1) * whole.weight
    moved, energy, motion, seen = (np.fft.rfft(x, 2 * count, axis=0) for x in (centred, squares, away, whole.weight))
    products = np.fft.irfft((np.abs(moved) ** 2).sum(axis=1))[:count]
    overlap = np.fft.irfft((np.conj(energy) * seen).real)[:count]  # mean of both ways round
    enough = np.fft.irfft((np.conj(motion) * seen).real)[:count] > LEAST_OVERLAP * whole.weight.mean() * away.sum()
    usable = count if enough.all() else int(np.argmin(enough))
    agreement = products[:usable] / overlap[:usable]
    below = np.flatnonzero(agreement < AGREES)
    if not len(below):
        return None
    after = agreement[below[0] :]
    best = float(after.max())
    peaks = 1 + np.flatnonzero((after[1:-1] >= after[:-2]) & (after[1:-1] >= after[2:]))
    good = peaks[after[peaks] >= REPEATING * best] if len(peaks) else peaks
    if best < AGREES or not len(good):
        return None
    return float(whole.step_s * (below[0] + good[0]))


def _likest(signal: Signal, period_s: float) -> float:
    """Of delays near a period the one after which rows that move differ least, by a parabola between frames."""
    whole = _between_rests(_by_frames(signal))
    values, weight = _without_outliers(whole.values), whole.weight
    moving = (np.gradient(values, axis=0) ** 2).sum(axis=1)
    near = round(period_s / whole.step_s)
    reach = max(round(NEAR_PERIOD * near), 2)
    delays = np.arange(max(near - reach, 1), min(near + reach, len(values) - 1) + 1)

    def differ(k: int) -> float:
        share = weight[k:] * weight[:-k] * (moving[k:] + moving[:-k])
        return float(share @ ((values[k:] - values[:-k]) ** 2).sum(axis=1) / max(share.sum(), 1e-300))

    found = np.array([differ(int(k)) for k in delays])
    best = int(found.argmin())
    if not 0 < best < len(found) - 1:
        return period_s
    before, here, after = found[best - 1 : best + 2]
    bend = before - 2 * here + after
    between = 0.5 * (before - after) / bend if bend > 0 else 0.0
    return float(whole.step_s * (delays[best] + between))


def moving_s(signal: Signal) -> float:
    """Seconds from the first to the last moment at which the joints are away from where they rest at the beginning."""
    whole = _by_frames(signal)
    moving = np.flatnonzero(_away(whole, whole.values[whole.weight > 0][:5]))
    return float(whole.step_s * np.ptp(moving)) if len(moving) else 0.0


def stopped_s(signal: Signal) -> tuple[float, float]:
    """Seconds from where the joints leave their first place to where they come to their last, and when that is [s]."""
    between = _between_rests(_by_frames(signal))
    return between.span_s, between.start_s + between.span_s


def _between_rests(whole: Sampled) -> Sampled:
    """From where the joints leave their first place to where they come to their last: a rest at an end agrees with
    itself at any delay."""
    known = whole.values[whole.weight > 0]
    left, come = (np.flatnonzero(_away(whole, rest)) for rest in (known[:5], known[-5:]))
    if not len(left) or not len(come) or come[-1] - left[0] < LEAST_ROWS:
        return whole
    kept = slice(left[0], come[-1] + 1)
    begin = whole.start_s + whole.step_s * float(left[0])
    return Sampled(begin, whole.step_s, whole.values[kept], whole.weight[kept], whole.noise_variance)


def _away(whole: Sampled, rest: Floats) -> NDArray[np.bool_]:
    """Where (n,) the joints are away from where they are in rows (., m)."""
    if not len(rest):
        return np.zeros(len(whole.values), dtype=bool)
    away = np.sqrt(((whole.values - np.median(rest, axis=0)) ** 2).mean(axis=1)) * whole.weight
    chance = float(np.sqrt(whole.noise_variance.mean()))
    return np.asarray(away > max(AWAY * np.quantile(away, 0.95), 2 * chance))  # bad frames are few
