"""Which points of the body an NLP keeps clear of obstacles: an exchange method over times and places.

A first NLP watches every vertex that its start brings near, in every row. What it finds is looked at on a grid between
rows and vertices; points that are too near are watched from then on, until the whole motion is proven clear.

Legend: T steps, N vertices, c gaps of a point.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from serpenoid.body import Floats
from serpenoid.optimise.clear.between import Between, GapField, Moments

# NEAR, MARGIN, DEEP beside other values: results/benchmarks/approach.md (benchmarks/approach.py)
NEAR = 0.3  # body lengths: with less, a body leaps between rows to where nothing is watched; with more nothing changes
SHARES = PLACES = (0.0, 0.25, 0.5, 0.75)  # where it is looked: in every step, on every edge
# an edge of length l goes l^2 / (8 r) into a disc of radius r between vertices that keep clear of it: 2.5e-3 for ten
# edges and r = 0.5
MARGIN = 1e-3  # body lengths kept at watched points: a tenth takes as long; ten times as much costs objective
DEEP = 5e-3  # twice that depth: what is nearer is mended by a wider margin, what is deeper by watching the point


class Watched(NamedTuple):
    """Gap `column` of the point at `place` [0, 1) from vertex `vertex` to the next, at `share` [0, 1) of `step`."""

    share: float
    step: int
    place: float
    vertex: int
    column: int


@dataclass(frozen=True)
class Watch:
    """Watched gaps, those at rows first."""

    points: tuple[Watched, ...] = ()

    @cached_property
    def instants(self) -> tuple[tuple[float, int, float], ...]:
        """All different (share, step, place), those at rows first."""
        return tuple(sorted({point[:3] for point in self.points}, key=lambda i: (i[0] > 0, *i)))

    def places(self, vertices: int, columns: int) -> dict[Watched, int]:
        """Where the watched gaps stand among all gaps of the instants: instant by instant, vertex by vertex."""
        number = {instant: i for i, instant in enumerate(self.instants)}
        return {p: (number[p[:3]] * vertices + p.vertex) * columns + p.column for p in self.points}

    def kept(self, vertices: int, columns: int) -> np.ndarray:
        """Places of the watched gaps, in order."""
        return np.array(sorted(self.places(vertices, columns).values()), int)

    def count(self, vertices: int, columns: int) -> int:
        """All gaps of the instants, watched or not."""
        return len(self.instants) * vertices * columns

    def moments(self, steps: int, vertices: int) -> tuple[Moments, np.ndarray]:
        """The watched points and the columns of their gaps."""
        share, step, place, vertex, column = (np.array(x) for x in zip(*self.points, strict=True))
        last_row, last = step == steps, vertex == vertices - 1
        at = Moments(step - last_row, np.where(last_row, 1.0, share), vertex - last, np.where(last, 1.0, place))
        return at, column

    def values(self, path: Between, field: GapField) -> Floats:
        """The watched gaps of motions (B): shape (B, points)."""
        at, column = self.moments(path.steps, len(path.levers))
        points = path.points(at)
        found, _ = field.at(points.reshape(-1, 2))
        return found.reshape(*points.shape[:2], -1)[:, np.arange(len(column)), column]


def every_vertex(steps: int, vertices: int, columns: int) -> Watch:
    """All gaps of all vertices in all rows 0 .. T."""
    rows, places, gaps = range(steps + 1), range(vertices), range(columns)
    return Watch(tuple(Watched(0.0, t, 0.0, v, c) for t in rows for v in places for c in gaps))


def near(watch: Watch, path: Between, field: GapField) -> Watch:
    """What of `watch` a motion brings near."""
    close = watch.values(path, field)[0] < NEAR
    return Watch(tuple(point for point, is_close in zip(watch.points, close, strict=True) if is_close))


def exchanged(watch: Watch, path: Between, field: GapField) -> Watch:
    """What to watch after a solve: what was watched, and of every step and edge what is too near."""
    kept = set(watch.points)
    steps, edges = np.arange(path.steps), np.arange(path.phi.shape[2])
    grid = [x.ravel() for x in np.meshgrid(steps, edges, SHARES, PLACES, indexing="ij")]
    at = Moments(grid[0].astype(int), grid[2], grid[1].astype(int), grid[3])
    gaps, _ = field.at(path.points(at)[0])
    by_edge = gaps.reshape(len(steps) * len(edges), -1, gaps.shape[1])
    worst = by_edge.argmin(1)
    for cell, column in np.argwhere(by_edge.min(1) < -DEEP):
        i = cell * by_edge.shape[1] + worst[cell, column]
        kept.add(Watched(float(at.share[i]), int(at.step[i]), float(at.place[i]), int(at.edge[i]), int(column)))
    return Watch(tuple(sorted(kept)))
