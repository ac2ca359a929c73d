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
from scipy.special import chdtri

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import ERROR
from serpenoid.diagnose.data.course import Course

DEGREE = 3
SPACING_S, SPACING_CYCLE = 0.078, 0.036  # between knots: seconds, at most this part of a cycle
PER_KNOT = 2.0  # readings that a knot wants
SAME = 0.5  # ticks: a reading that differs by less is the same
STIFF = 1e-4  # of a reading's weight, on second differences of coefficients: what nothing measures runs straight
STIFFER = (STIFF, 1e-2, 1.0, 1e2, 1e4)  # what cross-validation may choose


@dataclass(frozen=True)
class Source:
    """time (R,) [s], values (R, m) [rad], NaN unknown, and the standard deviation of each (m,) [rad]; worth (R,): how
    many readings each is."""

    time: Floats
    values: Floats
    sd: Floats
    worth: Floats

    @classmethod
    def of(cls, time: Floats, values: Floats, sd: Floats, tick: float = 0.0) -> Source:
        """Readings that are rounded to ticks [rad]."""
        return cls(time, values, sd, worth(values, tick) if tick else np.ones(len(time)))

    def until(self, end: float) -> Source:
        """The same to the first reading at or after a time [s]."""
        count = int(np.searchsorted(self.time, end)) + 1
        return replace(self, time=self.time[:count], values=self.values[:count], worth=self.worth[:count])


def worth(values: Floats, tick: float) -> Floats:
    """How many readings each of values (R, m) is worth: where all joints read the same ticks [rad] as before, their
    rounding is the same, too, and together such rows are one; readings that noise stirs are not."""
    run, first, runs = 0, values[0], np.zeros(len(values), dtype=int)
    for i, row in enumerate(values):
        if np.nanmax(np.abs(row - first), initial=0.0) > SAME * tick:
            run, first = run + 1, row
        runs[i] = run
    return np.asarray(1 / np.bincount(runs)[runs])


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
    knots = _knots(np.array([first, *inside, last]), apart)
    if carrier is None:
        return ShapeInTime(BSpline(knots, _tried(sources, knots, STIFFER if choose else (STIFF,)).chosen(), DEGREE))
    tried, joints = _tried([_both(s, carrier) for s in sources], knots, STIFFER), sources[0].values.shape[1]
    tried = tried if choose else tried.least_stiff()
    plain, about = tried.of(slice(joints)), tried.of(slice(joints, None))
    believed = ~about.refuted_by(plain)
    columns = np.empty((tried.columns.shape[1], joints))
    for t, those in zip((plain, about), (~believed, believed), strict=True):
        if those.any():
            columns[:, those] = t.of(those).chosen()
    angles = np.where(believed, carrier.angles, 0.0)
    return ShapeInTime(BSpline(knots, columns, DEGREE), replace(carrier, angles=angles))


def _both(source: Source, carrier: Course) -> Source:
    """Values as they are and, as further joints, about the carrier."""
    about = source.values - carrier.at(source.time)
    return replace(source, values=np.hstack([source.values, about]), sd=np.tile(source.sd, 2))


def _knots(ends: Floats, apart: float) -> Floats:
    """Even knots within each stretch, DEGREE-fold at its ends."""
    found = [np.repeat(ends[0], DEGREE + 1)]
    for begin, end in zip(ends[:-1], ends[1:], strict=True):
        pieces = max(1, round((end - begin) / apart))
        found += [begin + (end - begin) * np.arange(1, pieces) / pieces, np.repeat(end, DEGREE)]
    return np.concatenate([*found, ends[-1:]])


@dataclass(frozen=True)
class _Tried:
    """Splines of every stiffness: coefficients (S, K, m), scores of generalised cross-validation (S, m); count (m,) of
    the values."""

    columns: Floats
    scores: Floats
    count: Floats

    def of(self, joints: slice | np.ndarray) -> _Tried:
        """Those of some joints."""
        return _Tried(self.columns[:, :, joints], self.scores[:, joints], self.count[joints])

    def least_stiff(self) -> _Tried:
        """The least stiff alone."""
        return _Tried(self.columns[:1], self.scores[:1], self.count)

    @property
    def best(self) -> int:
        """The stiffness with the least score: the median joint's."""
        return int(np.median(self.scores, axis=1).argmin())

    def chosen(self) -> Floats:
        """Coefficients (K, m) of the best stiffness."""
        return np.asarray(self.columns[self.best])

    def refuted_by(self, other: _Tried) -> np.ndarray:
        """Which joints (m,) some other spline predicts better than the best by more than chance makes, were it right.

        What is right and not in the others adds s^2 to their chi squared, give or take 2 s of a normal number z: they
        gain by z^2 at most.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            gain = self.count * np.log(self.scores[self.best] / other.scores.min(axis=0))
        return np.asarray(gain > chdtri(1, ERROR / len(self.count)))


def _tried(sources: Sequence[Source], knots: Floats, stiffness: Sequence[float]) -> _Tried:
    """Splines of every stiffness."""
    bases = [BSpline.design_matrix(s.time, knots, DEGREE) for s in sources]
    count, joints = bases[0].shape[1], sources[0].values.shape[1]
    bend = np.diff(np.eye(count), 2, axis=0)
    curved = _band(bend.T @ bend)
    columns, scores = np.empty((len(stiffness), count, joints)), np.empty((len(stiffness), joints))
    for alike in _alike(sources):
        known = [np.isfinite(s.values[:, alike[0]]) for s in sources]
        sds = [s.sd[alike[0]] for s in sources]
        roots = [np.sqrt(s.worth[k])[:, None] / sd for s, sd, k in zip(sources, sds, known, strict=True)]
        base = vstack([b[np.flatnonzero(k)].multiply(w).tocsr() for b, w, k in zip(bases, roots, known, strict=True)])
        said = np.concatenate([s.values[k][:, alike] * w for s, w, k in zip(sources, roots, known, strict=True)])
        if len(said) < DEGREE:  # nothing is known of it
            columns[:, :, alike], scores[:, alike] = 0.0, 0.0
            continue
        square, right = (base.T @ base).toarray(), base.T @ said
        told = _band(square)
        for i, stiff in enumerate(stiffness):
            normal = told + stiff / min(sds) ** 2 * curved
            found = solveh_banded(normal, right, lower=True)
            columns[i][:, alike] = found
            count = float(sum(s.worth[k].sum() for s, k in zip(sources, known, strict=True)))
            freedom = count
            if len(stiffness) > 1:
                freedom = max(freedom - float(np.trace(solveh_banded(normal, square, lower=True))), 1.0)
            scores[i, alike] = count * ((said - base @ found) ** 2).sum(axis=0) / freedom**2
    return _Tried(columns, scores, np.sum([s.worth @ np.isfinite(s.values) for s in sources], axis=0))


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
