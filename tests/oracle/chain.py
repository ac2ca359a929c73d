"""Kinematics of a polygonal chain, and the serpenoid gait that bends it.

N: vertices, T: steps, m: joints; s runs from tail (0) to head (1).
kappa(s, t) = w1 sin(2 pi xi s) + w2 cos(2 pi xi s),
(w1, w2) = R_theta (a cos 2 pi t, a sigma sin 2 pi t) + (x_c, y_c).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def interior(vertices: int) -> tuple[int, ...]:
    """All vertices that have two edges."""
    return tuple(range(1, vertices - 1))


def gait_ellipse(
    steps: int, sigma: float, a: float, x_c: float = 0.0, y_c: float = 0.0, theta: float = 0.0
) -> tuple[Floats, Floats]:
    """(w1, w2) at t = 0, 1/T, ..., (T-1)/T, each shape (T,)."""
    t = np.arange(steps) / steps
    u, v = a * np.cos(2 * np.pi * t), a * sigma * np.sin(2 * np.pi * t)
    w1 = np.cos(theta) * u - np.sin(theta) * v + x_c
    w2 = np.sin(theta) * u + np.cos(theta) * v + y_c
    return w1, w2


def serpenoid_direction(s: Floats, w1: Floats, w2: Floats, xi: float) -> Floats:
    """psi(s) = integral of kappa from 0 to s; shape (T, len(s))."""
    k = 2 * np.pi * xi
    return np.outer(w1, (1 - np.cos(k * s)) / k) + np.outer(w2, np.sin(k * s) / k)


def serpenoid_joint_table(
    edge_lengths: ArrayLike,
    steps: int,
    *,
    sigma: float,
    a: float,
    xi: float,
    x_c: float = 0.0,
    y_c: float = 0.0,
    theta: float = 0.0,
    joints: Sequence[int] | None = None,
) -> Floats:
    """Joint angles, shape (T, m) [rad]: differences of psi between the midpoints of neighbouring rigid links."""
    edges = np.asarray(edge_lengths, dtype=float)
    arc = np.concatenate([[0.0], np.cumsum(edges / edges.sum())])
    bends = list(joints) if joints is not None else list(interior(len(arc)))
    ends = arc[[0, *bends, len(arc) - 1]]
    w1, w2 = gait_ellipse(steps, sigma, a, x_c, y_c, theta)
    return np.diff(serpenoid_direction((ends[1:] + ends[:-1]) / 2, w1, w2, xi), axis=1)


def edge_angles(joint_angles: ArrayLike, vertices: int, joints: Sequence[int] | None = None) -> Floats:
    """Angles of the edges with the first one at 0; shape (..., N - 1)."""
    table = np.asarray(joint_angles, dtype=float)
    bends = list(joints) if joints is not None else list(interior(vertices))
    turn = np.zeros((*table.shape[:-1], vertices - 1))
    turn[..., bends] = table  # vertex k stands between edges k - 1 and k
    return np.cumsum(turn, axis=-1)


def shape_vertices(joint_angles: ArrayLike, edges: Floats, weights: Floats, joints: Sequence[int] | None) -> Floats:
    """Vertices of the shapes in the frame of their weighted centroid and mean edge angle; shape (..., N, 2)."""
    psi = edge_angles(joint_angles, len(edges) + 1, joints)
    psi = psi - psi.mean(axis=-1, keepdims=True)
    steps = edges[:, None] * np.stack([np.cos(psi), np.sin(psi)], axis=-1)
    zero = np.zeros((*steps.shape[:-2], 1, 2))
    p = np.concatenate([zero, np.cumsum(steps, axis=-2)], axis=-2)
    return p - np.einsum("k,...kd->...d", weights, p)[..., None, :]


def place(pose: ArrayLike, points: Floats) -> Floats:
    """Rotate (N, 2) points by the pose's heading, then translate."""
    x, y, heading = np.asarray(pose, dtype=float)
    c, s = np.cos(heading), np.sin(heading)
    return points @ np.array([[c, s], [-s, c]]) + np.array([x, y])


def edge_tangents(p: Floats) -> Floats:
    """Unit edge vectors, tail to head; shape (..., N - 1, 2)."""
    d = np.diff(p, axis=-2)
    return d / np.linalg.norm(d, axis=-1, keepdims=True)


def vertex_tangents(p: Floats) -> Floats:
    """Normalised sum of the adjacent unit edges; the end vertices take their one edge. Shape (..., N, 2)."""
    e = edge_tangents(p)
    t = np.concatenate([e[..., :1, :], e[..., :-1, :] + e[..., 1:, :], e[..., -1:, :]], axis=-2)
    return t / np.linalg.norm(t, axis=-1, keepdims=True)
