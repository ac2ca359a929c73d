"""Noise of points, drawn so that an answer is the same however the film is turned or mirrored.

A draw is along and across the way from a body's tail to its head, in every frame, and comes in four mirrors: as it is,
reversed, and both reflected across the body. Whatever is done to the film is done to these. What is odd in noise
cancels between a draw and its reverse.

Lengths scatter by g(v) = v + a v^2 where v is the variance of a point's coordinate; with noise of g added once more,

    g(v + g) / g = (1 + x) / x^2,    x = v / g
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from serpenoid.measure.cells import Floats

MIRRORS = np.array([[1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]])


def own_noise(points: Floats, draws: int, generator: np.random.Generator | None = None) -> Iterator[Floats]:
    """Of points (F, N, 2), NaN hidden: for each draw white noise (4, F, N, 2) of variance 1 in its four mirrors."""
    rng = np.random.default_rng(0) if generator is None else generator
    ahead = np.nan_to_num(np.diff(points, axis=1)).sum(axis=1)
    heading = np.arctan2(ahead[:, 1], ahead[:, 0])
    along = np.stack([np.cos(heading), np.sin(heading)], axis=1)
    axes = np.stack([along, np.stack([-along[:, 1], along[:, 0]], axis=1)], axis=1)  # (F, 2, 2)
    for _ in range(draws):
        drawn = rng.normal(size=points.shape)
        yield np.stack([(drawn * mirror) @ axes for mirror in MIRRORS])


def share_of_scatter(growth: float) -> float:
    """x = v / g, by how many times g lengths scatter by with noise of g added once more."""
    return float(1 + np.sqrt(1 + 4 * growth)) / (2 * growth)
