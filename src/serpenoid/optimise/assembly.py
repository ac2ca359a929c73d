"""Where each step's small dense blocks go in the sparse Jacobian and Hessian of the whole cycle.

Variables are ordered (g_1, ..., g_T, q); g_0 is fixed at the origin and has no column.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
from scipy import sparse

from serpenoid.optimise.blocks import GAIT, OUTER, upper


def local_columns(steps: int) -> np.ndarray:
    """Column of each of the 12 local variables (g_t, g_{t+1}, q) of each step, -1 for g_0: shape (T, 12)."""
    t = np.arange(steps)[:, None]
    before, after = 3 * (t - 1) + np.arange(3), 3 * t + np.arange(3)
    before[0] = -1
    q = np.broadcast_to(3 * steps + np.arange(GAIT), (steps, GAIT))
    return np.hstack([before, after, q])


def scatter_jacobian(blocks: ca.MX, steps: int) -> ca.MX:
    """Residual Jacobian (3 T, 3 T + 6) from blocks (3, 12 T)."""
    columns = local_columns(steps)
    t, j, i = np.meshgrid(np.arange(steps), np.arange(OUTER), np.arange(3), indexing="ij")
    return _scatter(blocks, 3 * t + i, columns[t, j], (3 * steps, 3 * steps + GAIT))


def gather_gradient(blocks: ca.MX, steps: int) -> ca.MX:
    """Sum over steps of the gradients (1, 12 T), as a column (3 T + 6)."""
    columns = local_columns(steps).ravel()
    keep = columns >= 0
    where = (np.ones(keep.sum()), (columns[keep], np.flatnonzero(keep)))
    add = ca.DM(sparse.csc_matrix(where, shape=(3 * steps + GAIT, columns.size)))
    return ca.densify(add @ ca.vec(blocks))


def scatter_hessian(blocks: ca.MX, steps: int) -> ca.MX:
    """Upper triangle (3 T + 6, 3 T + 6) from the steps' packed upper triangles (78, T); overlapping entries add."""
    n, pairs = 3 * steps + GAIT, np.array(upper(OUTER))
    columns = local_columns(steps)
    a, b = columns[:, pairs[:, 0]], columns[:, pairs[:, 1]]
    keep = ((a >= 0) & (b >= 0)).ravel()
    rows, cols = np.minimum(a, b).ravel()[keep], np.maximum(a, b).ravel()[keep]
    places, target = np.unique(cols * n + rows, return_inverse=True)
    where = (np.ones(keep.sum()), (target, np.flatnonzero(keep)))
    add = ca.DM(sparse.csc_matrix(where, shape=(places.size, keep.size)))
    pattern = ca.Sparsity.triplet(n, n, (places % n).tolist(), (places // n).tolist())
    return ca.MX(pattern, ca.densify(add @ ca.vec(blocks)))


def _scatter(values: ca.MX, rows: np.ndarray, columns: np.ndarray, shape: tuple[int, int]) -> ca.MX:
    rows, columns = rows.ravel(), columns.ravel()
    keep = np.flatnonzero(columns >= 0)
    order = keep[np.lexsort((rows[keep], columns[keep]))]
    pattern = ca.Sparsity.triplet(*shape, rows[order].tolist(), columns[order].tolist())
    return ca.MX(pattern, ca.vec(values)[order.tolist()])
