"""Whether the body keeps clear between rows and between vertices, proven by interval halving.

Between two rows the joints turn at constant rates and the body frame moves evenly, as a robot plays a table
(`between.py`). In an interval of time and edge (half widths h, k about the middle) a point lies within h velocity + k
edge of the middle's, but for second-order terms that have bounds. A convex gap is above its tangent plane, so there it
is at least its value in the middle less |h gradient . velocity| + |k gradient . edge| and the rest; any other gap
changes no faster than the point moves. Intervals that are neither safe nor small are halved.

Legend: T steps, n edges, I intervals, c gaps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.optimise.clear.between import Between, GapField, Moments

RESOLUTION = 1e-4  # body lengths: a tenth of a millimetre on a robot of one metre
MOST = 2_000_000  # intervals that are looked at


@dataclass(frozen=True)
class Clearance:
    """least: the smallest gap found at any point and time; proven: a lower bound on all of them [body lengths]."""

    least: float
    proven: float

    @property
    def words(self) -> str:
        """One line for people."""
        return self.words_of("")

    def words_of(self, motion: str) -> str:
        """The same, with the motion that it is proven of."""
        proven = f"at least {self.proven:.2e} body lengths at every time and place{motion}, proven"
        return f"{proven}; the least gap found is {self.least:.2e}"


def clearance(path: Between, field: GapField, wanted: float = 0.0) -> Clearance:
    """Clearance of one motion.

    Intervals proven to be above `wanted` are not looked at again, so `proven` says no more than that where it is.
    """
    steps, edges = path.steps, path.phi.shape[2]
    step, edge = (x.ravel() for x in np.meshgrid(np.arange(steps), np.arange(edges), indexing="ij"))
    time, place = np.full(step.size, 0.5), np.full(step.size, 0.5)
    half_time, half_place = np.full(step.size, 0.5), np.full(step.size, 0.5)
    least, proven, seen = np.inf, np.inf, 0
    while step.size:
        value, by_time, by_place = _around(path, field, Moments(step, time, edge, place), half_time, half_place)
        bound, seen = (value - by_time - by_place).min(1), seen + step.size
        by_time, by_place = by_time.max(1), by_place.max(1)
        least = min(least, float(value.min()))
        final = (by_time + by_place <= RESOLUTION) | (seen > MOST)
        open_ = ~((bound >= min(wanted, least - RESOLUTION)) | final)
        done = bound[~open_]
        proven = min(proven, float(done.min(initial=np.inf)))
        later = by_time[open_] > by_place[open_]
        step, edge = (np.repeat(x[open_], 2) for x in (step, edge))
        time, half_time = _halved(time[open_], half_time[open_], later)
        place, half_place = _halved(place[open_], half_place[open_], ~later)
    return Clearance(least, min(proven, least))


def _around(
    path: Between, field: GapField, at: Moments, half_time: Floats, half_place: Floats
) -> tuple[Floats, Floats, Floats]:
    """Gaps (I, c) in the middle of the intervals, and how much lower they can be by time and by place, (I, c) each."""
    value, slope = field.at(path.points(at)[0])
    by_time, by_both = (x[0] for x in path.bends(at))
    late = _steepness(slope, path.velocities(at)[0], field) * half_time[:, None]
    far = _steepness(slope, path.along(at)[0], field) * half_place[:, None]
    rest = by_time * half_time**2 / 2 + by_both * half_time * half_place / 2
    return value, late + rest[:, None], far + (by_both * half_time * half_place / 2)[:, None]


def _steepness(slope: Floats, way: Floats, field: GapField) -> Floats:
    """How fast each gap can change along a way (I, 2), shape (I, c)."""
    along = np.abs(np.einsum("ick,ik->ic", slope, way))
    return np.where(field.convex, along, np.linalg.norm(way, axis=1)[:, None])


def _halved(middle: Floats, half: Floats, which: np.ndarray) -> tuple[Floats, Floats]:
    """Intervals twice over; those of `which` as their two halves."""
    quarter = np.where(which, half / 2, 0.0)
    both = np.stack([middle - quarter, middle + quarter], -1).ravel()
    return both, np.repeat(half - quarter, 2)
