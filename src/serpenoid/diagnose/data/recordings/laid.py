"""What cameras show beside servos' readings, by one clock of both, and what of it is another clock."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Floats
from serpenoid.measure.clock import ROBUST, interpolate_smoothly

SMOOTHED_S = 0.075  # of the readings' speed
OUTLYING = 5.0  # robust standard deviations
RANK = 1e-6  # of singular values: a wave of one harmonic is told by its neighbours
Plan = Callable[[Floats], Floats]  # joint angles, or bends, of servo times


@dataclass(frozen=True)
class Laid:
    """Of F frames and m bends: angles missed, readings and their speed, weights (F, m); how far each frame is from the
    middle of the film [s], and between which two readings it is (F,)."""

    miss: Floats
    reading: Floats
    speed: Floats
    weight: Floats
    away: Floats
    interval: NDArray[np.int64]

    @classmethod
    def by(cls, camera: Floats, at: Floats, angles: Floats, time: Floats, read: Floats, plan: Plan | None) -> Laid:
        """Frames at times of the cameras and, by a clock, of the servos. plan: only what servos do beside it is
        interpolated between readings, and that has no corners."""
        inside = (at > time[0]) & (at < time[-1])
        within = np.clip(at, time[0], time[-1])
        if plan is None:
            reading = interpolate_smoothly(time, read, within)
        else:
            reading = plan(within) + interpolate_smoothly(time, read - plan(time), within)
        speed = np.gradient(reading, axis=0) / np.gradient(at)[:, None]
        width = 2 * int(SMOOTHED_S / np.median(np.diff(camera)) / 2) + 1
        speed = np.stack([np.convolve(c, np.ones(width) / width, mode="same") for c in speed.T], axis=1)
        miss = np.where(inside[:, None], angles - reading, np.nan)
        miss = miss - np.nanmedian(miss, axis=0)
        scatter = ROBUST * np.nanmedian(np.abs(miss), axis=0)
        use = np.isfinite(miss) & (np.abs(miss) < np.maximum(OUTLYING * scatter, 0.05))
        weight = use / np.maximum(scatter, 1e-4) ** 2
        away = camera - camera.mean()
        return cls(np.where(use, miss, 0.0), reading, speed, weight, away, np.searchsorted(time, at))

    def step(self) -> tuple[Floats, Floats]:
        """By what the clock is off in the film's middle [s] and how its rate is; deviations of the two."""
        weight = self.weight
        columns = np.stack([self.speed, self.speed * self.away[:, None]])
        mean = (weight * columns).sum(axis=1) / np.maximum(weight.sum(axis=0), 1e-12)
        columns = columns - mean[:, None]
        normal = np.einsum("afj,bfj,fj->ab", columns, columns, weight)
        step = np.linalg.solve(normal, np.einsum("afj,fj,fj->a", columns, self.miss, weight))
        left = np.where(weight > 0, self.miss - np.tensordot(step, columns, axes=1), 0.0)
        covariance = np.linalg.inv(normal)
        moved = np.einsum("ab,bfj,fj,fj->fa", covariance, columns, left, weight)
        return step, np.sqrt(np.maximum(np.diag(covariance), _scatter(moved, self.interval)))

    def rate_apart(self) -> tuple[float, float]:
        """By what the rate is off, and its deviation, with all free that a displaced marker shows beside it: what goes
        with the sine and cosine of a joint and of its neighbours, which amid one cycle is much like a rate."""
        turned = np.stack([np.sin(self.reading), np.cos(self.reading)], axis=2)
        column = self.speed * self.away[:, None]
        own, left = np.zeros_like(column), np.zeros_like(column)
        for j in range(column.shape[1]):
            near = turned[:, max(j - 1, 0) : j + 2].reshape(len(column), -1)
            free = np.column_stack([np.ones(len(column)), self.speed[:, j], near])
            both, root = np.column_stack([column[:, j], self.miss[:, j]]), np.sqrt(self.weight[:, j])[:, None]
            own[:, j], left[:, j] = (both - free @ np.linalg.lstsq(root * free, root * both, rcond=RANK)[0]).T
        normal = float((self.weight * own**2).sum())
        if normal <= 0:
            return 0.0, np.inf
        step = float((self.weight * own * left).sum()) / normal
        moved = (self.weight * own * (left - step * own)).sum(axis=1, keepdims=True) / normal
        return step, float(np.sqrt(max(1 / normal, _scatter(moved, self.interval)[0])))


def _scatter(moved: Floats, interval: NDArray[np.int64]) -> Floats:
    """Variance (2,) of the sum of what each frame moves the clock by (F, 2): frames between the same two readings, and
    those next to them, have the error of a reading in common (Liang and Zeger, Biometrika 73, 13, 1986)."""
    sums = np.zeros((int(interval.max()) + 1, moved.shape[1]))
    np.add.at(sums, interval, moved)
    return np.asarray((sums**2).sum(axis=0) + 2 * (sums[1:] * sums[:-1]).sum(axis=0))
