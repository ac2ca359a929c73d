"""What readings miss of a course that is read later: in C where a compiler exists, else by NumPy.

Legend: K moments, R readings, m joints, C times of a course.
"""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any, Protocol

import numpy as np

from serpenoid.body import Floats
from serpenoid.mechanics.columns import call
from serpenoid.mechanics.compile import loaded
from serpenoid.mechanics.lanes import flags

SOURCE = """
void missed(const long joints, const double *restrict late, const double *restrict time, const double *restrict read,
            const double *restrict mesh, const double *restrict angles, double *restrict found, double *restrict sums,
            const long moments, const long readings, const long rows) {
  double *restrict squares = sums, *restrict pulls = sums + joints, *restrict powers = sums + 2 * joints;
  for (long k = 0; k < moments; ++k, found += 3) {
    long row = 0;
    for (long j = 0; j < 3 * joints; ++j) sums[j] = 0.0;
    for (long r = 0; r < readings; ++r) {
      double at = time[r] - late[k];
      at = at < mesh[0] ? mesh[0] : at > mesh[rows - 1] ? mesh[rows - 1] : at;
      while (row < rows - 2 && mesh[row + 1] < at) ++row;
      while (row > 0 && mesh[row] >= at) --row;
      const double ahead = at - mesh[row], often = 1.0 / (mesh[row + 1] - mesh[row]);
      const double *restrict here = angles + row * joints, *restrict then = here + joints;
      const double *restrict by = read + r * joints;
      for (long j = 0; j < joints; ++j) {
        const double rate = (then[j] - here[j]) * often, off = by[j] - (here[j] + ahead * rate);
        const int known = off == off;
        const double left = known ? off : 0.0, speed = known ? rate : 0.0;
        squares[j] += left * left, pulls[j] += left * speed, powers[j] += speed * speed;
      }
    }
    found[0] = found[1] = found[2] = 0.0;
    for (long j = 0; j < joints; ++j) found[0] += squares[j], found[1] += pulls[j], found[2] += powers[j];
  }
}
"""


class Followed(Protocol):
    """A course of time (C,) [s] and angles (C, m) [rad]."""

    @property
    def time(self) -> Floats: ...

    @property
    def angles(self) -> Floats: ...

    def followed(self, time: Floats) -> tuple[Floats, Floats]:
        """Joint angles (R, m) [rad], and how fast joints turned until then [rad/s]."""


def missed(course: Followed, time: Floats, angles: Floats, late: Floats) -> Floats:
    """Of readings, angles (R, m) [rad], NaN unknown, at time (R,) [s], beside a course that is read so much later (K,)
    [s]: sums (K, 3) of squares of what they miss [rad^2], of that by the speed [rad^2/s], and of squared speeds
    [rad^2/s^2]."""
    run = _missed()
    if run is None or len(course.time) < 2:
        return np.array([_at_once(course, time, angles, by) for by in late])
    joints, found = angles.shape[1], np.empty((len(late), 3))
    sizes = len(late), len(time), len(course.time)
    call(run, joints, [late, time, angles, course.time, course.angles], [found, np.empty(3 * joints)], *sizes)
    return found


def _at_once(course: Followed, time: Floats, angles: Floats, late: float) -> list[float]:
    there, speed = course.followed(time - late)
    off = angles - there
    known = np.isfinite(off)
    off, speed = np.where(known, off, 0.0), np.where(known, speed, 0.0)
    return [float((a * b).sum()) for a, b in ((off, off), (off, speed), (speed, speed))]


@cache
def _missed() -> Any:
    return loaded("missed", SOURCE, lambda library: ctypes.CDLL(library).missed, flags())
