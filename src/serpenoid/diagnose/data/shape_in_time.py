"""Joint angles as functions of time: regression splines of what servos read and markers show.

Cubic within each stretch of playing or pause, continuous across its ends, where the rate may jump:

    q(t) = sum_k c_k B_k(t),   sum_i w_i (z_i - q(t_i))^2 -> min,   w_i = 1 / s_i^2

The knots are as far apart as keeps what moves a gait and spreads a servo's ticks over several readings: unsmoothed
ticks in the joint rates would be rectified by every law with a sign in it, and look like friction. Where a log is too
slow for its knots, what the markers show of the same angles fills in. Where it is known what the servos should do (the
carrier), the spline is of the difference alone: neither the corners of a table's rows nor what happens between
slow readings is lost.

Legend: R readings, m joints, K coefficients.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import BSpline
from scipy.linalg import solveh_banded
from scipy.sparse import vstack

from serpenoid.body import Floats
from serpenoid.diagnose.data.course import Course

DEGREE = 3
SPACING_S, SPACING_CYCLE = 0.078, 0.036  # between knots: seconds, at most this part of a cycle
PER_KNOT = 2.0  # readings that a knot wants
STIFF = 1e-4  # of a reading's weight, on second differences of coefficients: what nothing measures runs straight
STIFFER = (STIFF, 1e-2, 1.0, 1e2, 1e4)  # what cross-validation may choose


@dataclass(frozen=True)
class Source:
    """time (R,) [s], values (R, m) [rad], NaN unknown, and the standard deviation of each (m,) [rad]."""

    time: Floats
    values: Floats
    sd: Floats

    def until(self, end: float) -> Source:
        """The same to the first reading at or after a time [s]."""
        count = int(np.searchsorted(self.time, end)) + 1
        return replace(self, time=self.time[:count], values=self.values[:count])


@dataclass(frozen=True)
class ShapeInTime:
    """The angles' spline, held constant beyond its ends, and what it is added to."""

    spline: BSpline
    carrier: Course | None = None

    def at(self, time: Floats) -> Floats:
        """Joint angles (R, m) [rad]."""
        knots = self.spline.t
        own = np.asarray(self.spline(np.clip(time, knots[0], knots[-1])))
        return own if self.carrier is None else own + self.carrier.at(time)


def spacing(cycle_s: float) -> float:
    """Between knots [s]."""
    return min(SPACING_S, SPACING_CYCLE * cycle_s)


def fitted(
    sources: Sequence[Source], corners: Floats, apart: float, choose: bool = False, carrier: Course | None = None
) -> ShapeInTime:
    """The spline of all sources about a carrier; corners: times at which the rate may jump; choose: how stiff, by
    cross-validation (Eilers and Marx, Statistical Science 11, 89, 1996)."""
    first, last = min(s.time[0] for s in sources), max(s.time[-1] for s in sources)
    inside = corners[(corners > first) & (corners < last)]
    if carrier is not None:
        sources = [replace(s, values=s.values - carrier.at(s.time)) for s in sources]
    knots = _knots(np.array([first, *inside, last]), apart)
    joints = sources[0].values.shape[1]
    carried = np.zeros(joints, dtype=bool) if carrier is None else np.any(carrier.angles, axis=0)
    return ShapeInTime(_fit(sources, knots, STIFFER if choose else (STIFF,), carried), carrier)


def _knots(ends: Floats, apart: float) -> Floats:
    """Even knots within each stretch, DEGREE-fold at its ends."""
    found = [np.repeat(ends[0], DEGREE + 1)]
    for begin, end in zip(ends[:-1], ends[1:], strict=True):
        pieces = max(1, round((end - begin) / apart))
        found += [begin + (end - begin) * np.arange(1, pieces) / pieces, np.repeat(end, DEGREE)]
    return np.concatenate([*found, ends[-1:]])


def _fit(sources: Sequence[Source], knots: Floats, stiffness: Sequence[float], carried: np.ndarray) -> BSpline:
    """The spline whose stiffness has the least score of generalised cross-validation: the median joint's, of those that
    are carried and of the others."""
    bases = [BSpline.design_matrix(s.time, knots, DEGREE) for s in sources]
    count, joints = bases[0].shape[1], sources[0].values.shape[1]
    bend = np.diff(np.eye(count), 2, axis=0)
    curved = _band(bend.T @ bend)
    columns, scores = np.empty((len(stiffness), count, joints)), np.empty((len(stiffness), joints))
    for alike in _alike(sources):
        known = [np.isfinite(s.values[:, alike[0]]) for s in sources]
        sds = [s.sd[alike[0]] for s in sources]
        base = vstack([b[np.flatnonzero(k)] / sd for b, sd, k in zip(bases, sds, known, strict=True)])
        said = np.concatenate([s.values[k][:, alike] / sd for s, sd, k in zip(sources, sds, known, strict=True)])
        square, right = (base.T @ base).toarray(), base.T @ said
        told = _band(square)
        for i, stiff in enumerate(stiffness):
            normal = told + stiff / min(sds) ** 2 * curved
            found = solveh_banded(normal, right, lower=True)
            columns[i][:, alike] = found
            freedom = float(len(said))
            if len(stiffness) > 1:
                freedom = max(freedom - float(np.trace(solveh_banded(normal, square, lower=True))), 1.0)
            scores[i, alike] = len(said) * ((said - base @ found) ** 2).sum(axis=0) / freedom**2
    chosen = np.empty((count, joints))
    for those in (each for each in (carried, ~carried) if each.any()):
        chosen[:, those] = columns[int(np.median(scores[:, those], axis=1).argmin())][:, those]
    return BSpline(knots, chosen, DEGREE)


def _band(matrix: Floats) -> Floats:
    """The diagonal of a symmetric matrix and those below it that B-splines fill (DEGREE + 1, K)."""
    size = len(matrix)
    return np.stack([np.append(np.diag(matrix, -i), np.zeros(i)) for i in range(min(DEGREE + 1, size))])


def _alike(sources: Sequence[Source]) -> list[list[int]]:
    """Joints that are known at the same times, with the same standard deviations: one matrix serves them all."""
    found: dict[tuple[bytes | float, ...], list[int]] = {}
    for joint in range(sources[0].values.shape[1]):
        seen = [(np.isfinite(s.values[:, joint]).tobytes(), float(s.sd[joint])) for s in sources]
        found.setdefault(tuple(x for pair in seen for x in pair), []).append(joint)
    return list(found.values())
