"""Where each step's small dense blocks go in the sparse Jacobian and Hessian of the whole cycle.

Local variables of step t are (g_t, g_{t+1}, a_t, a_{t+1}); those of the cycle are the poses (g_1, ..., g_T) and the
shapes (a_0, ..., a_{R-1}). g_0 is fixed at the origin and has no column.

Legend: T steps, R rows, s coordinates of a row, o = 6 + 2 s, v values per step.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np


@dataclass(frozen=True)
class Scatter:
    """Adds values[source[i]] to the place (rows[i], columns[i]) of a sparse matrix of `shape`."""

    rows: np.ndarray
    columns: np.ndarray
    source: np.ndarray
    shape: tuple[int, int]
    count: int

    def __call__(self, values: ca.MX) -> ca.MX:
        """The matrix of `count` values, given in any shape."""
        pattern, add = self._plan
        flat = ca.vec(values)
        if isinstance(add, ca.DM):
            return ca.MX(pattern, ca.densify(add @ flat))
        return ca.MX(pattern, flat[add])

    @cached_property
    def _plan(self) -> tuple[ca.Sparsity, ca.DM | list[int]]:
        key = self.columns.astype(np.int64) * self.shape[0] + self.rows
        places, target = np.unique(key, return_inverse=True)
        pattern = ca.Sparsity.triplet(
            *self.shape, (places % self.shape[0]).tolist(), (places // self.shape[0]).tolist()
        )
        if places.size == key.size:
            return pattern, self.source[np.argsort(target)].tolist()
        adds = ca.Sparsity.triplet(places.size, self.count, target.tolist(), self.source.tolist())
        return pattern, ca.DM(adds, 1.0)


def scatter(rows: np.ndarray, columns: np.ndarray, keep: np.ndarray, shape: tuple[int, int]) -> Scatter:
    """The Scatter of an array of values (in order) to rows and columns of the same shape, where `keep` says so."""
    chosen = np.flatnonzero(keep.ravel())
    return Scatter(rows.ravel()[chosen], columns.ravel()[chosen], chosen, shape, keep.size)


@dataclass(frozen=True)
class Places:
    """Columns of the local variables of every step: shape (T, o); -1 where they belong to the other group."""

    steps: int
    rows: int
    coordinates: int
    closed: bool

    @property
    def outer(self) -> int:
        """o = 6 + 2 s."""
        return 6 + 2 * self.coordinates

    @cached_property
    def poses(self) -> np.ndarray:
        """Pose columns; g_0 has none."""
        t = np.arange(self.steps)[:, None]
        before, after = 3 * (t - 1) + np.arange(3), 3 * t + np.arange(3)
        before[0] = -1
        return np.hstack([before, after, np.full((self.steps, 2 * self.coordinates), -1)])

    @cached_property
    def shapes(self) -> np.ndarray:
        """Shape columns."""
        t, s = np.arange(self.steps)[:, None], self.coordinates
        after = (t + 1) % self.rows if self.closed else t + 1
        return np.hstack([np.full((self.steps, 6), -1), s * t + np.arange(s), s * after + np.arange(s)])

    def jacobian(self, values: int) -> tuple[Scatter, Scatter]:
        """Blocks (v, o T) to (v T, 3 T) by the poses and (v T, s R) by the shapes."""
        t, j, i = np.meshgrid(np.arange(self.steps), np.arange(self.outer), np.arange(values), indexing="ij")
        shapes = (values * self.steps, 3 * self.steps), (values * self.steps, self.coordinates * self.rows)
        pair = []
        for columns, shape in zip((self.poses, self.shapes), shapes, strict=True):
            where = columns[t, j]
            pair.append(scatter(values * t + i, where, where >= 0, shape))
        return pair[0], pair[1]

    def gradient(self) -> tuple[Scatter, Scatter]:
        """Blocks (o, T) or (1, o T) to columns (3 T) and (s R)."""
        zero = np.zeros_like(self.poses)
        sizes = 3 * self.steps, self.coordinates * self.rows
        pair = [scatter(c, zero, c >= 0, (n, 1)) for c, n in zip((self.poses, self.shapes), sizes, strict=True)]
        return pair[0], pair[1]

    def hessian(self) -> tuple[Scatter, Scatter, Scatter]:
        """Blocks (o, o T) to: poses by poses (upper triangle), poses by shapes, shapes by shapes (both triangles)."""
        g, a = 3 * self.steps, self.coordinates * self.rows
        t, j, i = np.meshgrid(*(np.arange(n) for n in (self.steps, self.outer, self.outer)), indexing="ij")
        pose_i, pose_j, shape_i, shape_j = self.poses[t, i], self.poses[t, j], self.shapes[t, i], self.shapes[t, j]
        return (
            scatter(pose_i, pose_j, (pose_i >= 0) & (pose_j >= pose_i), (g, g)),
            scatter(pose_i, shape_j, (pose_i >= 0) & (shape_j >= 0), (g, a)),
            scatter(shape_i, shape_j, (shape_i >= 0) & (shape_j >= 0), (a, a)),
        )
