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

    def late(self, time: Floats, readings: Floats, near: float) -> float:
        """By how much later [s], no more than `near`, the course is read best (R, m), NaN unknown, at time (R,)."""
        known = np.isfinite(readings)
        rates = self._steps / np.diff(self.time)[:, None]
        late = 0.0
        for _ in range(MEETINGS):
            at = time - late
            rate = np.where(known, rates[np.clip(np.searchsorted(self.time, at) - 1, 0, len(rates) - 1)], 0.0)
            missed = np.where(known, readings - self.at(at), 0.0)
            change = float((missed * rate).sum() / max(float((rate**2).sum()), 1e-12))
            late, before = float(np.clip(late - change, -near, near)), late
            if abs(late - before) < MET_S:
                break
        return late
