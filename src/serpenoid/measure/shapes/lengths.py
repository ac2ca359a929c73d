"""How long the edges of a body are in every frame, by its points: distances, or of an animal arcs along its curve.

    arc = |p_{k+1} - p_k| / (chord over arc of the curve that the links' directions draw)

Chords shorten where the body bends; a body's length along itself does not. Noise of points lengthens both, and an
animal's points are close together. What noise lengthens arcs by is found by adding it once more (`without_noise`):

    length = mean(m) / (1 + x (mean(m with noise of g) / mean(m) - 1))
    g(v) = v + a v^2,     g(v + g) / g = (1 + x) / x^2

m: arcs, v: variance of a point's coordinate, g: the same by what arcs scatter by, which is more of a curve that noise
bends, x = v / g. Along the body noise lengthens one edge and shortens the next, a body that stretches does so by long
waves: g is told by the short ones of all waves that so many edges show. Paths are not smoothed: that cuts corners where
few frames show a beat, and shortens the body. Only where noise is no longer small beside an edge it costs less than
noise does, and the same is done with the smoothed path.

Legend: F frames, N vertices, E edges.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Body
from serpenoid.body_curve import SMOOTH, curve
from serpenoid.measure.cells import Floats
from serpenoid.measure.clock import ROBUST, bridged
from serpenoid.measure.shapes.links import marker_angles
from serpenoid.measure.shapes.own_noise import own_noise, share_of_scatter
from serpenoid.measure.shapes.smooth import cross_validated, smooth

STRETCHED = 3.0  # times its median: no edge grows so long; a point is astray
ODD = 5.0  # robust SDs about the median: an edge whose end is where it is not
LEAST_ODD = 0.02  # of a length: what is less does no harm, and of a body that rests the SD is none
LONG_WAVES = 1 / 3  # of all waves along the body: the longest, by which bodies stretch
LARGE = 0.25  # of an edge: such a noise is no longer small beside it
NEAR = 2  # joints to either side of an edge
OFTEN_AS_FAR = 5.0  # times: an edge that usually turns by so much more than joints near it is bent by the spline alone
DRAWS = 2  # of noise, each in four mirrors: what is odd in it does not hide what is even


def shown_lengths(body: Body, points: Floats) -> Floats:
    """Of every edge in every frame (F, N - 1), in the unit of points (F, N, 2); NaN where an end of one is hidden.

    body: its edges in proportion, which decide where along the curve its points are.
    """
    distances = np.asarray(np.linalg.norm(np.diff(points, axis=1), axis=2))
    return distances / chord_shares(body, points) if body.is_animal else distances


def without_noise(body: Body, time_s: Floats, points: Floats) -> Floats:
    """The same (F, E) of an animal, every edge less what noise of points lengthens it by in frames that show all."""
    found = shown_lengths(body, points)
    rows = np.flatnonzero(np.isfinite(points).all(axis=(1, 2)))
    if len(rows):
        rows = rows[(found[rows] <= STRETCHED * np.median(found[rows], axis=0)).all(axis=1)]
    seen, raw = points[rows], found[rows]
    if not len(rows):
        return found
    variance = _noise_variance(body, raw, seen)
    if variance > (LARGE * float(np.median(raw))) ** 2:
        by = cross_validated(time_s[rows], seen.reshape(len(rows), -1))
        if by is not None:
            seen = smooth(seen.reshape(len(rows), -1), *by).reshape(seen.shape)
            raw = found[rows] = shown_lengths(body, seen)
            variance = _noise_variance(body, raw, seen)
    if not variance > 0:
        return found
    noisy = [seen + each for noise in own_noise(seen, DRAWS) for each in np.sqrt(variance) * noise]
    lengths = [shown_lengths(body, each) for each in noisy]
    growth = np.mean([_noise_variance(body, *each) for each in zip(lengths, noisy, strict=True)]) / variance
    own = min(1.0, share_of_scatter(float(growth)))
    longer = np.mean([usual(each) for each in lengths], axis=0) / usual(raw) - 1
    return found / (1 + own * longer)


def usual(lengths: Floats) -> Floats:
    """Mean (E,) of every edge (F, E) over the frames that show it about as long as usual; NaN where none does."""
    return mean_of(lengths, in_place(lengths))


def mean_of(lengths: Floats, used: NDArray[np.bool_]) -> Floats:
    """Mean (E,) of every edge (F, E) over the frames in which it is `used` (F, E); NaN where in none."""
    often = used.sum(axis=0)
    total = np.where(used, lengths, 0.0).sum(axis=0)
    return np.where(often > 0, total / np.maximum(often, 1), np.nan)


def in_place(lengths: Floats) -> NDArray[np.bool_]:
    """Which edges (F, E) are seen and about as long as usual."""
    known = np.isfinite(lengths)
    ever = known.any(axis=0)
    middle = np.zeros(lengths.shape[1])
    middle[ever] = np.nanmedian(lengths[:, ever], axis=0)
    away = np.abs(np.where(known, lengths, np.nan) - middle)
    scatter = np.zeros_like(middle)
    scatter[ever] = ROBUST * np.nanmedian(away[:, ever], axis=0)
    return known & ~(away > np.maximum(ODD * scatter, LEAST_ODD * middle))


def _noise_variance(body: Body, lengths: Floats, points: Floats) -> float:
    """Of a coordinate of points (F, N, 2), by what their lengths (F, E) scatter by: the middle one of
    waves along the body that no body stretches by."""
    count = lengths.shape[1]
    places, halves = np.arange(count) + 0.5, np.arange(max(1, int(LONG_WAVES * count)), count)  # half waves on the body
    waves = np.cos(np.pi * np.outer(places, halves) / count)
    beside = np.diag(np.cos(marker_angles(body, points)).mean(axis=0), 1)
    by_noise = ((2 * np.eye(count) - beside - beside.T) @ waves * waves).sum(axis=0)
    return float(np.median(_scatter(lengths @ waves) ** 2 / by_noise))


def _scatter(columns: Floats) -> Floats:
    """Robust SD of columns (F, c) about their medians (c,)."""
    return np.asarray(ROBUST * np.median(np.abs(columns - np.median(columns, axis=0)), axis=0))


def chord_shares(body: Body, points: Floats, between: Sequence[int] | None = None, degree: int = SMOOTH) -> Floats:
    """Chord over arc (F, N - 1), at most 1, or between some of the vertices; bends that a frame does not show are those
    of frames before and after; degree: of the curve's spline."""
    bends = bridged(np.arange(float(len(points))), marker_angles(body, points))
    drawn = curve(body, np.concatenate([np.zeros((len(bends), 1)), np.cumsum(bends, axis=1)], axis=1), degree=degree)
    ends = list(range(body.vertices) if between is None else between)
    arcs = np.diff(np.concatenate([[0.0], np.cumsum(body.edges)])[ends])
    shares = np.asarray(np.linalg.norm(np.diff(drawn[:, ends], axis=1), axis=2) / arcs)
    if between is not None:
        return shares
    turns = _turns(bends)
    beyond = np.median(shares, axis=0) < _of_circle(OFTEN_AS_FAR * turns)
    return np.where(beyond, _of_circle(turns), shares)


def _turns(bends: Floats) -> Floats:
    """How far edges (N - 1,) may turn, by joint angles (F, N - 2): as those of the two joints to either side of it that
    is bent most, as a root mean square. The spline through few points of many bends turns several times as far, above
    all where it runs out beyond the last joint: the end of a snake came out twice as long as its points were apart."""
    wide = np.pad(np.sqrt((bends**2).mean(axis=0)), NEAR)
    return np.asarray(np.lib.stride_tricks.sliding_window_view(wide, 2 * NEAR).max(axis=1))


def _of_circle(turns: Floats) -> Floats:
    """Chord over arc of a circle's part that turns so far; of more than half of it as of half."""
    return np.asarray(np.sinc(np.minimum(turns, np.pi) / (2 * np.pi)))
