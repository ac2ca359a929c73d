"""How long the edges of a body are in every frame, by its points: distances, or of an animal arcs along its curve.

    arc = |p_{k+1} - p_k| / (chord over arc of the curve that the links' directions draw)

Chords shorten where the body bends; a body's length along itself does not. Noise of points lengthens both, and an
animal's points are close together: their paths are smoothed first (`steady_lengths`). Smoothing cuts corners where few
frames show a beat, and a body whose corners are cut is shorter. That is seen without knowing the beat: arcs do not
change in time, so what they scatter by is noise, and what noise lengthens is known from it.

Legend: F frames, N vertices.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.body import Body
from serpenoid.body_curve import SMOOTH, curve
from serpenoid.measure.cells import Floats
from serpenoid.measure.clock import bridged
from serpenoid.measure.shapes.links import marker_angles
from serpenoid.measure.shapes.smooth import DEGREE, WINDOWS, cross_validated, smooth, smoother

SURE = 3.0  # standard errors of a median: a body shorter by more than noise and this has its corners cut
ROBUST = 1.4826  # SD over median distance from the median, of normal numbers
STRETCHED = 3.0  # times its median: no edge grows so long; a point is astray, and would be smeared over a window
OF_MEDIAN = 1.2533  # standard error of a median over that of a mean, of normal numbers


def shown_lengths(body: Body, points: Floats) -> Floats:
    """Of every edge in every frame (F, N - 1), in the unit of points (F, N, 2); NaN where an end of one is hidden.

    body: its edges in proportion, which decide where along the curve its points are.
    """
    distances = np.asarray(np.linalg.norm(np.diff(points, axis=1), axis=2))
    return distances / chord_shares(body, points) if body.is_animal else distances


def steady_lengths(body: Body, time_s: Floats, points: Floats) -> Floats:
    """The same (F, N - 1) of an animal whose points' paths are smoothed, in frames that show all of them where they
    are, as much as predicts them best, but never so much that the body is shorter than noise makes it."""
    found = shown_lengths(body, points)
    rows = np.flatnonzero(np.isfinite(points).all(axis=(1, 2)))
    if len(rows):
        rows = rows[(found[rows] <= STRETCHED * np.median(found[rows], axis=0)).all(axis=1)]
    columns = points[rows].reshape(len(rows), 2 * body.vertices)
    best = cross_validated(time_s[rows], columns)
    if best is None:
        return found
    for window in (w for w in reversed(WINDOWS) if DEGREE < w <= best[1].shape[1]):
        smoothed = smooth(columns, *smoother(time_s[rows], window)).reshape(len(rows), -1, 2)
        lengths = shown_lengths(body, smoothed)
        if not _cuts_corners(body, found[rows], smoothed, lengths):
            found[rows] = lengths
            break
    return found


def _cuts_corners(body: Body, raw: Floats, smoothed: Floats, lengths: Floats) -> bool:
    """Whether a body is shorter by lengths (F, N - 1) of smoothed points (F, N, 2) than by raw ones, by more than noise
    of the points lengthens those."""
    noise = float(np.median(_scatter(raw))) / np.sqrt(2)  # of one coordinate: an arc has two ends
    noisy = smoothed + noise * np.random.default_rng(0).normal(size=smoothed.shape)
    whole = raw.sum(axis=1)
    shorter, by_noise = (_middle(each) - _middle(lengths) for each in (raw, shown_lengths(body, noisy)))
    error = OF_MEDIAN * float(_scatter(whole[:, None])[0]) / np.sqrt(len(whole))
    return shorter > by_noise + SURE * error


def _middle(lengths: Floats) -> float:
    """Of the whole body: the sum of every edge's median."""
    return float(np.median(lengths, axis=0).sum())


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
    return np.asarray(np.linalg.norm(np.diff(drawn[:, ends], axis=1), axis=2) / arcs)
