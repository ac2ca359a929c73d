"""Joint angles at times, straight in between, and by how much later they are read.

Legend: C times of a course, R readings, m joints.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Floats

MEETINGS = 9  # steps in which it is found how late a course is read: each far smaller than the last
MET_S = 1e-6  # a step that ends them
WITHIN = 12  # moments within a row, and again between two of these
COURSES = 16  # of a joint, that are kept
SOME = 100  # a course's rows from one to the next that it is looked up by
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

    @cached_property
    def by_joint(self) -> Floats:
        """Of each joint, its angles (m, C) [rad]."""
        return np.ascontiguousarray(self.angles.T)


@dataclass(frozen=True)
class Readings:
    """Readings (R, m) [rad] of a trial, NaN unknown, at time (R,) [s]: by how much later a course is read best, no more
    than `near` [s].

    apart [s]: of rows that jump, 0 if none do. Readings amid a jump alone say which way a course that jumps is off, so
    that within a row it is looked for at every moment. That is done by some of them (LOOKED_AT), from there all say.
    What a joint's readings miss of a course at a moment is kept: from fit to fit most joints play the same.
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
        nearer = self._met(course, late)
        return min((late, nearer), key=lambda t: float(np.nansum((self.angles - course.at(self.time - t)) ** 2)))

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
            best = int(moments[np.argmin(self._missed(course, step, moments))])
            late = min(max(best * step, -self.near), self.near)
        return late

    def _missed(self, course: Course, step: float, moments: np.ndarray) -> Floats:
        """Sums of squares (K,) [rad^2] of what readings miss at each of the moments (K,), in steps [s]."""
        total, asked = np.zeros(len(moments)), moments.tolist()
        places: dict[tuple[int, ...], tuple[NDArray[np.int64], Floats]] = {}  # of readings, which all joints share
        for joint, angles in enumerate(course.by_joint):
            mine = self._of_course(joint, angles)
            new = tuple(n for n in asked if (step, n) not in mine)
            if new:
                if new not in places:
                    late = np.clip(step * np.array(new), -self.near, self.near)[:, None]
                    places[new] = course.places(self.time - late)
                row, ahead = places[new]
                if not self._known[:, joint].all():
                    row, ahead = row[:, self._known[:, joint]], ahead[:, self._known[:, joint]]
                here = angles.take(row)
                left = angles.take(course.following.take(row))
                left -= here
                left /= course.apart.take(row)
                left *= ahead
                left += here
                left -= self._read[joint]
                mine.update(zip([(step, n) for n in new], np.einsum("kr,kr->k", left, left).tolist(), strict=True))
            total += [mine[step, n] for n in asked]
        return total

    def _of_course(self, joint: int, angles: Floats) -> dict[tuple[float, int], float]:
        """What a joint's readings missed of a course (C,), by step and moment; some of its angles find it."""
        kept, some = self._kept[joint], angles[::SOME].tobytes()
        if some not in kept or not np.array_equal(kept[some][0], angles):
            kept[some] = angles, {}
        if len(kept) > COURSES:
            del kept[next(iter(kept))]
        return kept[some][1]

    @cached_property
    def _known(self) -> NDArray[np.bool_]:
        """What was read (R, m)."""
        return np.isfinite(self.angles)

    @cached_property
    def _read(self) -> list[Floats]:
        """Of each joint, what was read."""
        return [self.angles[known, joint] for joint, known in enumerate(self._known.T)]

    @cached_property
    def _kept(self) -> list[dict[bytes, tuple[Floats, dict[tuple[float, int], float]]]]:
        """Of each joint, of its last courses, their angles and what was missed."""
        return [{} for _ in range(self.angles.shape[1])]

    def _met(self, course: Course, late: float) -> float:
        """By Gauss-Newton, from `late` on."""
        unknown = ~self._known
        for _ in range(MEETINGS):
            angles, rate = course.followed(self.time - late)
            missed = self.angles - angles
            missed[unknown] = rate[unknown] = 0.0
            change = float((missed * rate).sum() / max(float((rate**2).sum()), 1e-12))
            late, before = float(np.clip(late - change, -self.near, self.near)), late
            if abs(late - before) < MET_S:
                break
        return late
