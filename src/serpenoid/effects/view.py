"""What cameras and clocks report of a motion: the thing that observation effects transform. SI, by numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from serpenoid.body import Floats


@dataclass(frozen=True)
class View:
    """markers (R, N, 2) [m] at camera times (R,) [s since the start]; servo_times (R,): the same moments on its clock.

    vertices (R, N, 2) [m]: where the body is, whatever is seen of it.
    gaps (G,) [s]: when each gap of all markers ends; directions (G,) [rad]: where a jump across it would go.
    """

    markers: Floats
    times: Floats
    servo_times: Floats
    gaps: Floats
    directions: Floats
    vertices: Floats

    @classmethod
    def true(
        cls, vertices: Floats, times: Floats, gaps: Sequence[float] = (), directions: Sequence[float] = ()
    ) -> View:
        """Without any effect."""
        times, there = np.asarray(times, float), np.asarray(vertices, float)
        return cls(there, times, times, np.asarray(gaps, float), np.asarray(directions, float), there)

    def displaced(self, vertex: int, edge: int, along: float, left: float) -> View:
        """With one marker moved with an edge of the body: so far along it [m], and so far to its left."""
        e = self.direction(edge)
        return self.moved(vertex, along * e + left * left_of(e))

    def direction(self, edge: int) -> Floats:
        """Of an edge of the body (R, 2), towards the head."""
        e = self.vertices[:, edge + 1] - self.vertices[:, edge]
        return np.asarray(e / np.linalg.norm(e, axis=-1, keepdims=True))

    def moved(self, vertex: int, by: Floats) -> View:
        """With one marker moved by (R, 2) [m]."""
        markers = self.markers.copy()
        markers[:, vertex] += by
        return replace(self, markers=markers)


def left_of(way: Floats) -> Floats:
    """Directions (R, 2) a quarter of a turn to the left."""
    return np.stack([-way[:, 1], way[:, 0]], -1)
