"""How long the edges of a body are in every frame, by its points: distances, or of an animal arcs along its curve.

    arc = |p_{k+1} - p_k| / (chord over arc of the curve that the links' directions draw)

Chords shorten where the body bends; a body's length along itself does not. Noise of points lengthens both, and an
animal's points are close together: their paths are smoothed first (`steadied`).

Legend: F frames, N vertices.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.body import Body
from serpenoid.body_curve import curve
from serpenoid.measure.cells import Floats
from serpenoid.measure.clock import bridged
from serpenoid.measure.links import marker_angles
from serpenoid.measure.smooth import cross_validated, smooth


def shown_lengths(body: Body, points: Floats) -> Floats:
    """Of every edge in every frame (F, N - 1), in the unit of points (F, N, 2); NaN where an end of one is hidden.

    body: its edges in proportion, which decide where along the curve its points are.
    """
    distances = np.asarray(np.linalg.norm(np.diff(points, axis=1), axis=2))
    return distances / chord_shares(body, points) if body.is_animal else distances


def steadied(time_s: Floats, points: Floats) -> Floats:
    """Points (F, N, 2) with their paths smoothed in time; hidden ones stay hidden."""
    columns = points.reshape(len(points), -1)
    rows = np.flatnonzero(np.isfinite(columns).all(axis=1))
    weights = cross_validated(time_s[rows], columns[rows])
    if weights is None:
        return points
    found = columns.copy()
    found[rows] = smooth(columns[rows], *weights)
    return found.reshape(points.shape)


def chord_shares(body: Body, points: Floats, between: Sequence[int] | None = None) -> Floats:
    """Chord over arc (F, N - 1), at most 1, or between some of the vertices; bends that a frame does not show are those
    of frames before and after."""
    bends = bridged(np.arange(float(len(points))), marker_angles(body, points))
    drawn = curve(body, np.concatenate([np.zeros((len(bends), 1)), np.cumsum(bends, axis=1)], axis=1))
    ends = list(range(body.vertices) if between is None else between)
    arcs = np.diff(np.concatenate([[0.0], np.cumsum(body.edges)])[ends])
    return np.asarray(np.linalg.norm(np.diff(drawn[:, ends], axis=1), axis=2) / arcs)
