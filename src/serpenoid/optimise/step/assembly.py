"""Where each step's small dense blocks go in the sparse Jacobian and Hessian of the whole cycle.

Local variables of step t are (g_t, g_{t+1}, a_t, a_{t+1}); those of the cycle are the poses (g_1, ..., g_T) and the
shapes (a_0, ..., a_{R-1}). g_0 is fixed at the origin and has no column.

Legend: T steps, R rows, d numbers of a pose, s coordinates of a row, o = 2 d + 2 s, v values per step.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

MOST_PASSES = 4  # of gathering; where more entries meet at a place, a sparse product adds them


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
        pattern, passes, add = self._plan
        flat = ca.vec(values)
        if add is not None:
            return ca.MX(pattern, ca.densify(add @ flat))
        if len(passes) > 1:
            flat = ca.vertcat(flat, 0)  # what a pass takes where nothing is left to add
        return ca.MX(pattern, sum((flat[chosen] for chosen in passes[1:]), flat[passes[0]]))

    @cached_property
    def _plan(self) -> tuple[ca.Sparsity, list[list[int]], ca.DM | None]:
        key = self.columns.astype(np.int64) * self.shape[0] + self.rows
        order = np.argsort(key, kind="stable")
        places, first, counts = np.unique(key[order], return_index=True, return_counts=True)
        pattern = ca.Sparsity.triplet(
            *self.shape, (places % self.shape[0]).tolist(), (places // self.shape[0]).tolist()
        )
        most = int(counts.max(initial=1))
        if most > MOST_PASSES:
            target = np.repeat(np.arange(places.size), counts)
            adds = ca.Sparsity.triplet(places.size, self.count, target.tolist(), self.source[order].tolist())
            return pattern, [], ca.DM(adds, 1.0)
        taken = np.append(self.source[order], self.count)
        passes = [taken[np.where(counts > i, first + i, taken.size - 1)].tolist() for i in range(most)]
        return pattern, passes, None


Scatters = tuple[Scatter, Scatter, Scatter]  # poses by poses, poses by shapes, shapes by shapes


class Upper:
    """The upper triangle of a symmetric (size, size), put together from parts that may meet at places, in one go."""

    def __init__(self, size: int) -> None:
        self.size, self._count = size, 0
        self._values: list[ca.MX] = []
        self._entries: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []

    def scatter(self, values: ca.MX, parts: Iterable[tuple[Scatter, int, int]]) -> None:
        """Values that Scatters take to their places from (row, column) on."""
        for part, row, column in parts:
            self._entries.append((part.rows + row, part.columns + column, part.source + self._count))
        self._values.append(ca.vec(values))
        self._count += values.numel()

    def matrix(self, values: ca.MX, row: int = 0, column: int = 0) -> None:
        """A sparse matrix from (row, column) on."""
        if values.nnz():
            rows, columns = (np.array(x, int) for x in values.sparsity().get_triplet())
            part = Scatter(rows, columns, np.arange(rows.size), values.shape, rows.size)
            self.scatter(values.nz[:], [(part, row, column)])

    def __call__(self) -> ca.MX:
        """The matrix."""
        rows, columns, source = (np.concatenate(x) for x in zip(*self._entries, strict=True))
        above = rows <= columns
        whole = Scatter(rows[above], columns[above], source[above], (self.size, self.size), self._count)
        return whole(ca.vertcat(*self._values))


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
    pose: int = 3

    @property
    def outer(self) -> int:
        """o = 2 d + 2 s."""
        return 2 * (self.pose + self.coordinates)

    @cached_property
    def poses(self) -> np.ndarray:
        """Pose columns; g_0 has none."""
        t, d = np.arange(self.steps)[:, None], np.arange(self.pose)
        before, after = self.pose * (t - 1) + d, self.pose * t + d
        before[0] = -1
        return np.hstack([before, after, np.full((self.steps, 2 * self.coordinates), -1)])

    @cached_property
    def shapes(self) -> np.ndarray:
        """Shape columns."""
        t, s = np.arange(self.steps)[:, None], self.coordinates
        after = (t + 1) % self.rows if self.closed else t + 1
        return np.hstack([np.full((self.steps, 2 * self.pose), -1), s * t + np.arange(s), s * after + np.arange(s)])

    def jacobian(self, values: int) -> tuple[Scatter, Scatter]:
        """Blocks (v, o T) to (v T, d T) by the poses and (v T, s R) by the shapes."""
        t, j, i = np.meshgrid(np.arange(self.steps), np.arange(self.outer), np.arange(values), indexing="ij")
        shapes = (values * self.steps, self.pose * self.steps), (values * self.steps, self.coordinates * self.rows)
        pair = []
        for columns, shape in zip((self.poses, self.shapes), shapes, strict=True):
            where = columns[t, j]
            pair.append(scatter(values * t + i, where, where >= 0, shape))
        return pair[0], pair[1]

    def gradient(self) -> tuple[Scatter, Scatter]:
        """Blocks (o, T) or (1, o T) to columns (d T) and (s R)."""
        zero = np.zeros_like(self.poses)
        sizes = self.pose * self.steps, self.coordinates * self.rows
        pair = [scatter(c, zero, c >= 0, (n, 1)) for c, n in zip((self.poses, self.shapes), sizes, strict=True)]
        return pair[0], pair[1]

    def hessian(self) -> Scatters:
        """Blocks (o, o T) to: poses by poses (upper triangle), poses by shapes, shapes by shapes (both triangles)."""
        g, a = self.pose * self.steps, self.coordinates * self.rows
        t, j, i = np.meshgrid(*(np.arange(n) for n in (self.steps, self.outer, self.outer)), indexing="ij")
        pose_i, pose_j, shape_i, shape_j = self.poses[t, i], self.poses[t, j], self.shapes[t, i], self.shapes[t, j]
        return (
            scatter(pose_i, pose_j, (pose_i >= 0) & (pose_j >= pose_i), (g, g)),
            scatter(pose_i, shape_j, (pose_i >= 0) & (shape_j >= 0), (g, a)),
            scatter(shape_i, shape_j, (shape_i >= 0) & (shape_j >= 0), (a, a)),
        )
