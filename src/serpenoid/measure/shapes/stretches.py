"""How an animal's edges lengthen and shorten in time, beyond noise of its points, and its points without that.

    lengths - their means = stretches + noise n,      n ~ N(0, s^2 V),      V_jj = 2, V_j,j+1 = - mean cos bend_j
    u = (lengths - means) root(V)^-T                  noise of points is alike in all directions of u

Noise of points lengthens edges as much as a body that stretches does, and where it lasts (trackers smooth what they
see) time does not tell them apart. What does: noise is alike in all directions, a body stretches in a few, by waves of
the whole of it. A principal component of u is a stretch where it is larger than the largest that chance makes of
noise alike in it and all that are smaller, in as many frames as count as independent by how long those last,

    variance > s^2 (m + 2.02 t) / n,    m = (r + p)^2,    t = (r + p) (1/r + 1/p)^(1/3),    r^2 = n - 1,  p^2: of these

(Johnstone, Annals of Statistics 29, 2001: the largest of a white Wishart matrix; one in a hundred is beyond 2.02). So
are all that are larger. Each is taken off as smooth in time as it predicts itself best: what is as quick as the film
stays noise, and so is what is no more than arcs and chords differ by: the curve between points is guessed. A body that
does not stretch has none. Where no two directions are alike (points that lie evenly along a drawn midline) noise is
none of points, and nothing is taken off.

Legend: F frames, N points, E = N - 1 edges; lengths in body lengths.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from serpenoid.body import Body
from serpenoid.body_curve import curve
from serpenoid.measure.cells import Floats
from serpenoid.measure.clock import held
from serpenoid.measure.shapes.links import from_centroid, marker_angles
from serpenoid.measure.shapes.principal_bends import BendFinder
from serpenoid.measure.shapes.smooth import cross_validated, smooth

BY_CHANCE = 2.0234  # 99th percentile of the Tracy-Widom distribution, real numbers
MEMORY = 0.1  # of the frames: the lags over which noise may last
LEAST_NOISE = 2  # directions: of one alone nobody knows whether noise is alike in it and others
FEWEST = 8  # frames, and as many as directions: fewer tell nothing of them


@dataclass(frozen=True)
class Stretches:
    """How much longer than usual each edge is in every frame (F, E), smooth; alike: what varies is noise, the same in
    all directions."""

    longer: Floats
    alike: bool = False

    @property
    def any(self) -> bool:
        """Whether the body stretches at all."""
        return bool(self.longer.any())


def stretches(body: Body, time_s: Floats, points: Floats) -> Stretches:
    """Of points (F, N, 2), from the frames that show all of them; between these, and beyond, as next to them."""
    chords = np.asarray(np.linalg.norm(np.diff(points, axis=1), axis=2))
    rows = np.flatnonzero(np.isfinite(chords).all(axis=1))
    nothing = np.zeros_like(chords)
    if len(rows) < max(FEWEST, chords.shape[1]):
        return Stretches(nothing)
    angles = marker_angles(body, points[rows])
    bends = BendFinder.of(body, time_s[rows]).bends(angles).smoothed(angles)
    lengths = chords[rows] / _shares(body, bends)
    away = lengths - lengths.mean(axis=0)
    root = np.linalg.cholesky(_pattern(bends))
    noisy, sizes, axes = np.linalg.svd(np.linalg.solve(root, away.T).T, full_matrices=False)
    courses = noisy * sizes
    count = _beyond_chance(courses)
    noise = float((courses[:, count:] ** 2).mean())
    guessed = np.linalg.solve(root, (lengths - chords[rows]).T).T @ axes.T
    surely = [k for k in range(count) if (courses[:, k] ** 2).mean() > noise + guessed[:, k].var()]
    if not surely or count > len(axes) - LEAST_NOISE:
        return Stretches(nothing, alike=not count)
    steady = np.column_stack([_steady(time_s[rows], courses[:, k]) for k in surely])
    return Stretches(held(time_s[rows], steady @ axes[surely] @ root.T, time_s))


def unstretched(body: Body, points: Floats, found: Stretches, rigid: Floats) -> Floats:
    """Points (F, N, 2) where they would be did the body not stretch, its centroid where it is; rigid (F, N, 2): its
    chain in each frame, NaN where that is not known and points stay."""
    moved = np.einsum(
        "kj,fji->fki", from_centroid(body), (found.longer / body.edges)[..., None] * np.diff(rigid, axis=1)
    )
    return np.asarray(points - np.nan_to_num(moved))


def _shares(body: Body, bends: Floats) -> Floats:
    """Chord over arc (F, E) of a curve that bends so (F, m)."""
    drawn = curve(body, np.concatenate([np.zeros((len(bends), 1)), np.cumsum(bends, axis=1)], axis=1))
    return np.asarray(np.linalg.norm(np.diff(drawn, axis=1), axis=2) / body.edges)


def _pattern(bends: Floats) -> Floats:
    """Covariance (E, E) of edges' lengths per variance of a point, the mean of frames that bend so (F, m)."""
    beside = -np.cos(bends).mean(axis=0)
    return 2 * np.eye(len(beside) + 1) + np.diag(beside, 1) + np.diag(beside, -1)


def _beyond_chance(courses: Floats) -> int:
    """How many of principal components (F, E), the largest first, are larger than noise alike in each of them and all
    that are smaller makes the largest; frames count by how long the usual component lasts."""
    squares, count = (courses**2).mean(axis=0), courses.shape[1]
    frames = _independent(courses)
    for k in range(count - 1):
        root, side = np.sqrt(max(frames - 1, 1.0)), np.sqrt(count - k)
        chance = (root + side) ** 2 + BY_CHANCE * (root + side) * (1 / root + 1 / side) ** (1 / 3)
        if frames < count - k or squares[k] <= squares[k + 1 :].mean() * chance / frames:
            return k
    return count - 1


def _independent(courses: Floats) -> float:
    """As how many frames those of courses (F, E) count, in the middle of these: F over the sum of squares of its
    correlation, less what chance makes of them."""
    count = len(courses)
    size = np.maximum((courses**2).sum(axis=0), np.finfo(float).tiny)
    lags = range(1, max(1, int(MEMORY * count)) + 1)
    alike = sum(((courses[lag:] * courses[:-lag]).sum(axis=0) / size) ** 2 - 1 / count for lag in lags)
    return float(count / (1 + 2 * max(float(np.median(alike)), 0.0)))


def _steady(time_s: Floats, course: Floats) -> Floats:
    """A course (F,) as smooth as predicts it best; nothing, where its mean does."""
    by = cross_validated(time_s, course[:, None])
    if by is None:
        return np.zeros_like(course)
    found = smooth(course[:, None], *by)[:, 0]
    own = by[0][by[1] == np.arange(len(course))[:, None]].sum()
    predicts = ((course - found) ** 2).sum() / (len(course) - own) ** 2
    return found if predicts < (course**2).sum() / (len(course) - 1) ** 2 else np.zeros_like(course)
