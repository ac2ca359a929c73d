"""Chains of rigid links in numbers: vertices of joint angles, rigid registration.

Pose: weighted centroid and mean edge angle. Legend: F rows, N vertices, m joints.
"""

from __future__ import annotations

import numpy as np

from serpenoid.body import Body, Floats
from serpenoid.body_curve import curve
from serpenoid.measure.shapes.links import laid_over, link_of_edge

LEAST_MARKERS = 3  # two fix a pose, a third says how well
GYRATION = 0.29  # of a straight rod, body lengths


def shapes(body: Body, angles: Floats) -> Floats:
    """Vertices (F, N, 2) [m] in the body frame of joint angles (F, m)."""
    psi = np.concatenate([np.zeros((len(angles), 1)), np.cumsum(angles, axis=1)], axis=1)
    if body.is_animal:
        return curve(body, psi) * body.total_length_m
    psi = psi[:, link_of_edge(body)]
    psi = psi - psi.mean(axis=1, keepdims=True)
    points = np.zeros((len(angles), body.vertices), dtype=complex)
    np.cumsum(body.edges_m * np.exp(1j * psi), axis=1, out=points[:, 1:])
    points -= (points @ body.vertex_weights)[:, None]
    return points.view(float).reshape(*points.shape, 2)


def register(points: Floats, markers: Floats) -> tuple[Floats, Floats]:
    """Poses (F, 3) that carry points (F, N, 2) to visible markers by least squares, and residuals (F, N, 2).

    NaN where fewer than three markers are seen. Points are in the body frame, so the pose is that of the body.
    """
    count = np.isfinite(markers[..., 0]).sum(axis=1)
    heading, mid_p, mid_m = laid_over(points, markers)
    place = mid_m - turn(heading, mid_p)
    poses = np.column_stack([place, heading])
    poses[count < LEAST_MARKERS] = np.nan
    known = np.isfinite(poses[:, 2])
    poses[known, 2] = np.unwrap(poses[known, 2])
    residual = markers - place[:, None] - turn(heading[:, None], points)
    residual[count < LEAST_MARKERS] = np.nan
    return poses, np.asarray(residual)


def placed(points: Floats, poses: Floats) -> Floats:
    """Points (F, N, 2) of the body frame at poses (F, 3)."""
    return poses[:, None, :2] + turn(poses[:, 2:], points)


def turn(angle: Floats, vectors: Floats) -> Floats:
    """Vectors (..., 2) turned by angles (...)."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def way(body: Body, squares: Floats) -> float:
    """RMS [m] over a straight body's points of a displacement whose mean squares are (3,) [m^2, m^2, rad^2]."""
    return float(np.sqrt(squares[0] + squares[1] + (GYRATION * body.total_length_m) ** 2 * squares[2]))
