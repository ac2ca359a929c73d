"""Joint angles at times, straight in between, and by how much later they are read.

Legend: C times of a course, R readings, m joints.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Floats
from serpenoid.diagnose.data.shapes.beside_course import missed

MEETINGS = 9  # steps in which it is found how late a course is read: each far smaller than the last
MET_S = 1e-6  # a step that ends them
WITHIN = 12  # moments within a row, and again between two of these
LOOKED_AT = 500  # readings of a trial that say about when it began (results/benchmarks/late_starts.md)


@dataclass(frozen=True)
class Course:
    """Joint angles (C, m) [rad] at time (C,) [s], straight in between, held beyond."""

    time: Floats
    angles: Floats

    def at(self, time: Floats) -> Floats:
        """Joint angles (R, m) [rad]."""
        return self._ahead(*self.places(time))[0]

    def places(self, time: Floats) -> tuple[NDArray[np.int64], Floats]:
        """Of times (...,), the rows of the course they follow, and by how much [s]."""
        inside = np.clip(time, self.time[0], self.time[-1])
        row = np.searchsorted(self.time, inside, side="right") - 1
        return row, inside - self.time[row]

    def late(self, time: Floats, readings: Floats, near: float, apart: float = 0.0) -> float:
        """By how much later [s] it is read: see `Readings`."""
        return Readings(time, readings, near, apart).late(self)

    def followed(self, time: Floats) -> tuple[Floats, Floats]:
        """Joint angles (R, m) [rad], and how fast joints turned until then [rad/s]: beyond the ends as beside them."""
        row = np.clip(np.searchsorted(self.time, time) - 1, 0, max(len(self.time) - 2, 0))
        ahead = np.clip(time, self.time[0], self.time[-1]) - self.time[row]
        angles, rates = self._ahead(row, ahead)
        there = ahead == self.apart[row]  # at the next row, and not beside it by what is rounded
        angles[there] = self.angles[row[there] + 1]
        return angles, rates

    def _ahead(self, row: NDArray[np.int64], ahead: Floats) -> tuple[Floats, Floats]:
        """Joint angles (R, m) so long [s] after rows, and how fast they turn there; of a fine mesh few rows are ever
        asked for."""
        here = self.angles[row]
        slopes = self.angles[self.following[row]]
        slopes -= here
        slopes /= self.apart[row, None]
        here += ahead[:, None] * slopes
        return here, slopes

    @cached_property
    def following(self) -> NDArray[np.int64]:
        """The next row of each (C,), of the last itself."""
        return np.minimum(np.arange(1, len(self.time) + 1), len(self.time) - 1)

    @cached_property
    def apart(self) -> Floats:
        """Time to the next row (C,) [s], of the last any."""
        return np.append(np.diff(self.time), 1.0)


@dataclass(frozen=True)
class Readings:
    """Readings (R, m) [rad] of a trial, NaN unknown, at time (R,) [s]: by how much later a course is read best, no more
    than `near` [s].

    apart [s]: of rows that jump, 0 if none do. Readings amid a jump alone say which way a course that jumps is off, so
    that within a row it is looked for at every moment. That is done by some of them (LOOKED_AT), from there all say.
    """

    time: Floats
    angles: Floats
    near: float
    apart: float = 0.0

    def late(self, course: Course) -> float:
        """[s]."""
        if not self.apart:
            return self._met(course, 0.0)
        late = self._some._about(course)
        both = np.array([late, self._met(course, late)])
        return float(both[self._missed(course, both)[:, 0].argmin()])

    @cached_property
    def _some(self) -> Readings:
        """Some of the readings, evenly spaced."""
        every = max(len(self.time) // LOOKED_AT, 1)
        return self if every == 1 else replace(self, time=self.time[::every], angles=self.angles[::every])

    def _about(self, course: Course) -> float:
        """The best of all moments [s] within a row of where slopes lead."""
        late = self._met(course, 0.0)
        for step in (self.apart / WITHIN, self.apart / WITHIN**2):
            most = int(np.ceil(self.near / step))  # the last one is at the end
            moments = np.unique(np.clip(round(late / step) + np.arange(-WITHIN, WITHIN + 1), -most, most))
            tried = np.clip(moments * step, -self.near, self.near)
            late = float(tried[self._missed(course, tried)[:, 0].argmin()])
        return late

    def _met(self, course: Course, late: float) -> float:
        """By Gauss-Newton, from `late` on."""
        for _ in range(MEETINGS):
            _, pull, power = self._missed(course, np.array([late]))[0]
            late, before = float(np.clip(late - pull / max(power, 1e-12), -self.near, self.near)), late
            if abs(late - before) < MET_S:
                break
        return late

    def _missed(self, course: Course, late: Floats) -> Floats:
        """See `missed`."""
        return missed(course, self.time, self.angles, late)
