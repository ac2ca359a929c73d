"""Joint angles as functions of time: regression splines of what servos read and markers show.

Cubic within each stretch of playing or pause, continuous across its ends, where the rate may jump:

    q(t) = sum_k c_k B_k(t),   sum_i w_i (z_i - q(t_i))^2 -> min,   w_i = 1 / s_i^2

The knots are as far apart as keeps what moves a gait and spreads a servo's ticks over several readings: unsmoothed
ticks in the joint rates would be rectified by every law with a sign in it, and look like friction. Where a log is too
slow for its knots, what the markers show of the same angles fills in.

Legend: R readings, m joints, K coefficients.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from serpenoid.body import Floats

DEGREE = 3
SPACING_S, SPACING_CYCLE = 0.078, 0.036  # between knots: seconds, at most this part of a cycle
COARSER = (1.0, 1.5, 2.25, 3.4)  # what cross-validation may choose where markers are all there is
PER_KNOT = 2.0  # readings that a knot wants
STIFF = 1e-4  # of a reading's weight, on second differences of coefficients: what nothing measures runs straight


@dataclass(frozen=True)
class Source:
    """time (R,) [s], values (R, m) [rad], NaN unknown, and the standard deviation of each (m,) [rad]."""

    time: Floats
    values: Floats
    sd: Floats


@dataclass(frozen=True)
class ShapeInTime:
    """The angles' spline; held constant beyond its ends."""

    spline: BSpline

    def at(self, time: Floats) -> Floats:
        """Joint angles (R, m) [rad]."""
        knots = self.spline.t
        return np.asarray(self.spline(np.clip(time, knots[0], knots[-1])))


def spacing(cycle_s: float) -> float:
    """Between knots [s]."""
    return min(SPACING_S, SPACING_CYCLE * cycle_s)


def fitted(sources: Sequence[Source], corners: Floats, apart: float, choose: bool = False) -> ShapeInTime:
    """The spline of all sources; corners: times at which the rate may jump; choose: knots by cross-validation."""
    first, last = min(s.time[0] for s in sources), max(s.time[-1] for s in sources)
    inside = corners[(corners > first) & (corners < last)]
    best: tuple[float, BSpline] | None = None
    for coarser in COARSER if choose else (1.0,):
        score, spline = _fit(sources, _knots(np.array([first, *inside, last]), coarser * apart))
        if best is None or score < best[0]:
            best = score, spline
    if best is None:
        raise ValueError("no spacing of knots was tried.")
    return ShapeInTime(best[1])


def _knots(ends: Floats, apart: float) -> Floats:
    """Even knots within each stretch, DEGREE-fold at its ends."""
    found = [np.repeat(ends[0], DEGREE + 1)]
    for begin, end in zip(ends[:-1], ends[1:], strict=True):
        pieces = max(1, round((end - begin) / apart))
        found += [begin + (end - begin) * np.arange(1, pieces) / pieces, np.repeat(end, DEGREE)]
    return np.concatenate([*found, ends[-1:]])


def _fit(sources: Sequence[Source], knots: Floats) -> tuple[float, BSpline]:
    """Score of generalised cross-validation (the median joint's), and the spline."""
    bases = [BSpline.design_matrix(s.time, knots, DEGREE).toarray() for s in sources]
    bend = np.diff(np.eye(bases[0].shape[1]), 2, axis=0)
    columns, scores = [], []
    for joint in range(sources[0].values.shape[1]):
        known = [np.isfinite(s.values[:, joint]) for s in sources]
        base = np.concatenate([b[k] / s.sd[joint] for b, s, k in zip(bases, sources, known, strict=True)])
        said = np.concatenate([s.values[k, joint] / s.sd[joint] for s, k in zip(sources, known, strict=True)])
        normal = base.T @ base + STIFF / min(s.sd[joint] for s in sources) ** 2 * bend.T @ bend
        columns.append(np.linalg.solve(normal, base.T @ said))
        freedom = max(len(said) - normal.shape[0], 1)
        scores.append(len(said) * ((said - base @ columns[-1]) ** 2).sum() / freedom**2)
    return float(np.median(scores)), BSpline(knots, np.stack(columns, axis=1), DEGREE)
