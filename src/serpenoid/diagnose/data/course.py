"""Joint angles at times, straight in between.

Legend: C times of a course, R readings, m joints.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from serpenoid.body import Floats

MEETINGS = 9  # steps in which it is found how late a course is read: each far smaller than the last
MET_S = 1e-6  # a step that ends them
WITHIN = 12  # moments within a row, and again between two of these


@dataclass(frozen=True)
class Course:
    """Joint angles (C, m) [rad] at time (C,) [s], straight in between, held beyond."""

    time: Floats
    angles: Floats

    def at(self, time: Floats) -> Floats:
        """Joint angles (R, m) [rad]."""
        if len(self.time) == 1:
            return np.repeat(self.angles, len(time), axis=0)
        inside = np.clip(time, self.time[0], self.time[-1])
        row = np.clip(np.searchsorted(self.time, inside, side="right") - 1, 0, len(self.time) - 2)
        found = self.angles[row]
        share = (inside - self.time[row]) / np.maximum(self.time[row + 1] - self.time[row], 1e-12)
        found += share[:, None] * self._steps[row]
        return found

    @cached_property
    def _steps(self) -> Floats:
        """From each time to the next (C - 1, m) [rad]."""
        return np.diff(self.angles, axis=0)

    def late(self, time: Floats, readings: Floats, near: float, apart: float = 0.0) -> float:
        """By how much later [s], no more than `near`, the course is read best (R, m), NaN unknown, at time (R,).

        apart [s]: of rows that jump, 0 if none do. Readings amid a jump alone say which way a course that jumps is off,
        so that within a row it is looked for at every moment.
        """
        late = self._met(time, readings, near, 0.0)
        for step in (apart / WITHIN, apart / WITHIN**2) if apart else ():
            tried = np.clip(late + step * np.arange(-WITHIN, WITHIN + 1), -near, near)
            late = float(tried[np.argmin([self._missed(time, readings, t) for t in tried])])
        if not apart:
            return late
        nearer = self._met(time, readings, near, late)
        return min((late, nearer), key=lambda t: self._missed(time, readings, t))

    def _missed(self, time: Floats, readings: Floats, late: float) -> float:
        """Sum of squares [rad^2] of what readings miss."""
        return float(np.nansum((readings - self.at(time - late)) ** 2))

    def _met(self, time: Floats, readings: Floats, near: float, late: float) -> float:
        """By Gauss-Newton, from `late` on."""
        known = np.isfinite(readings)
        rates = self._steps / np.diff(self.time)[:, None]
        for _ in range(MEETINGS):
            at = time - late
            rate = np.where(known, rates[np.clip(np.searchsorted(self.time, at) - 1, 0, len(rates) - 1)], 0.0)
            missed = np.where(known, readings - self.at(at), 0.0)
            change = float((missed * rate).sum() / max(float((rate**2).sum()), 1e-12))
            late, before = float(np.clip(late - change, -near, near)), late
            if abs(late - before) < MET_S:
                break
        return late
