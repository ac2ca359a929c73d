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

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.interpolate import BSpline
from scipy.linalg import solveh_banded
from scipy.sparse import vstack
from scipy.special import chdtri

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import ERROR
from serpenoid.diagnose.data.shapes.course import Course

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
        if (np.abs(row - first) > SAME * tick).any():  # not of what is unknown
            run, first = run + 1, row
        runs[i] = run
    return np.asarray(1 / np.bincount(runs)[runs])


@dataclass(frozen=True)
class ShapeInTime:
    """The angles' spline, held constant beyond its ends, and what it is added to; what it is a fit to, and how stiff
    each joint's is (m,)."""

    spline: BSpline
    sources: tuple[Source, ...]
    stiffness: Floats
    carrier: Course | None = None

    def at(self, time: Floats) -> Floats:
        """Joint angles (R, m) [rad]."""
        own = np.asarray(self.spline(self._within(time)))
        return own if self.carrier is None else own + self.carrier.at(time)

    def covariance(self, times: Floats) -> Floats:
        """Of each joint's means over some times (R, T): (m, R, R) [rad^2], as readings scatter about the spline, which
        is s^2 B N^-1 B^t, N the normal matrix of the fit, stiffness included (Wahba, J. R. Stat. Soc. B 45, 133, 1983).
        """
        here = self._base(times.ravel()).reshape(*times.shape, -1).mean(axis=1)
        found = np.zeros((self.spline.c.shape[1], len(times), len(times)))
        for mine, solved, squares in self._scattered(here):
            found[mine] = (here @ solved) * squares[:, None, None]
        return found

    def variance(self, time: Floats) -> Floats:
        """Of each joint's angle at each of some times (R,): (R, m) [rad^2]; see `covariance`."""
        here = self._base(time)
        found = np.zeros((len(time), self.spline.c.shape[1]))
        for mine, solved, squares in self._scattered(here):
            found[:, mine] = np.einsum("rk,kr->r", here, solved)[:, None] * squares
        return found

    def _scattered(self, here: Floats) -> Iterator[tuple[list[int], Floats, Floats]]:
        """Of rows B (R, K): joints that are alike, N^-1 B^t (K, R), and each of these joints' s^2."""
        left = [s.values - self.at(s.time) for s in self.sources]
        for stiff in np.unique(self.stiffness):
            for alike in _alike(self.sources):
                mine = [j for j in alike if self.stiffness[j] == stiff]
                told = _Told.of(self.sources, self.spline.t, mine, left) if mine else None
                if told is not None and told.enough:
                    normal = told.normal(stiff)
                    solved = np.asarray(solveh_banded(normal, here.T, lower=True))
                    yield mine, solved, (told.said**2).sum(axis=0) / told.freedom(normal)

    def _base(self, time: Floats) -> Floats:
        """B-splines (R, K) at some times."""
        return np.asarray(BSpline.design_matrix(self._within(time), self.spline.t, DEGREE).toarray())

    def _within(self, time: Floats) -> Floats:
        return np.clip(time, self.spline.t[0], self.spline.t[-1])


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
    joints = sources[0].values.shape[1]
    if carrier is None:
        plain = _tried(sources, knots, STIFFER if choose else (STIFF,))
        stiff = np.full(joints, STIFFER[plain.best])
        return ShapeInTime(BSpline(knots, plain.chosen(), DEGREE), tuple(sources), stiff)
    tried = _tried([_both(s, carrier) for s in sources], knots, STIFFER)
    tried = tried if choose else tried.least_stiff()
    plain, about = tried.of(slice(joints)), tried.of(slice(joints, None))
    believed = ~about.refuted_by(plain)
    columns, stiff = np.empty((tried.columns.shape[1], joints)), np.empty(joints)
    for t, those in zip((plain, about), (~believed, believed), strict=True):
        if those.any():
            own = t.of(those)
            columns[:, those], stiff[those] = own.chosen(), STIFFER[own.best]
    angles = np.where(believed, carrier.angles, 0.0)
    return ShapeInTime(BSpline(knots, columns, DEGREE), tuple(sources), stiff, replace(carrier, angles=angles))


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


@dataclass(frozen=True)
class _Told:
    """What sources say of joints that are alike, whitened: base (R, K), said (R, J), square (K, K) = base^t base; count
    of the values; sd: the smallest of a source."""

    base: Any
    said: Floats
    square: Floats
    count: float
    sd: float

    @classmethod
    def of(cls, sources: Sequence[Source], knots: Floats, alike: Sequence[int], values: Sequence[Floats]) -> _Told:
        """values (R, m) of each source, which may be others than its own."""
        known = [np.isfinite(s.values[:, alike[0]]) for s in sources]
        sds = [s.sd[alike[0]] for s in sources]
        roots = [np.sqrt(s.worth[k])[:, None] / sd for s, sd, k in zip(sources, sds, known, strict=True)]
        bases = [BSpline.design_matrix(s.time, knots, DEGREE)[k] for s, k in zip(sources, known, strict=True)]
        base = vstack([b.multiply(w).tocsr() for b, w in zip(bases, roots, strict=True)])
        said = np.concatenate([v[k][:, alike] * w for v, w, k in zip(values, roots, known, strict=True)])
        count = float(sum(s.worth[k].sum() for s, k in zip(sources, known, strict=True)))
        return cls(base, said, (base.T @ base).toarray(), count, min(sds))

    @property
    def enough(self) -> bool:
        """Whether anything is known of them."""
        return len(self.said) >= DEGREE

    def normal(self, stiff: float) -> Floats:
        """The normal matrix of a stiffness, as a band."""
        return np.asarray(_band(self.square) + stiff / self.sd**2 * _curved(len(self.square)))

    def freedom(self, normal: Floats) -> float:
        """How many of the values the fit does not take."""
        return max(self.count - float(np.trace(solveh_banded(normal, self.square, lower=True))), 1.0)


def _tried(sources: Sequence[Source], knots: Floats, stiffness: Sequence[float]) -> _Tried:
    """Splines of every stiffness."""
    coefficients, joints = len(knots) - DEGREE - 1, sources[0].values.shape[1]
    columns, scores = np.zeros((len(stiffness), coefficients, joints)), np.zeros((len(stiffness), joints))
    for alike in _alike(sources):
        told = _Told.of(sources, knots, alike, [s.values for s in sources])
        if not told.enough:
            continue
        right = told.base.T @ told.said
        for i, stiff in enumerate(stiffness):
            normal = told.normal(stiff)
            found = solveh_banded(normal, right, lower=True)
            freedom = told.freedom(normal) if len(stiffness) > 1 else told.count
            columns[i][:, alike] = found
            scores[i, alike] = told.count * ((told.said - told.base @ found) ** 2).sum(axis=0) / freedom**2
    return _Tried(columns, scores, np.sum([s.worth @ np.isfinite(s.values) for s in sources], axis=0))


@lru_cache(maxsize=64)
def _curved(count: int) -> Floats:
    """Squares of the second differences of so many coefficients, as a band."""
    bend = np.diff(np.eye(count), 2, axis=0)
    return _band(bend.T @ bend)


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
