"""The body frame of given chains: weighted centroid (baseline weights), mean edge angle.

Legend: R rows, N vertices.
"""

from __future__ import annotations

import numpy as np

from serpenoid.body import Floats
from serpenoid.model import Model


def body_poses(model: Model, vertices: Floats) -> Floats:
    """Pose (weighted centroid, mean edge angle, unwrapped over rows) of chains (R, N, 2): shape (R, 3)."""
    centroid = np.einsum("rni,n->ri", vertices, model.body.vertex_weights)
    edge = np.diff(vertices, axis=1)
    angles = np.unwrap(np.arctan2(edge[..., 1], edge[..., 0]), axis=1)
    return np.column_stack([centroid, np.unwrap(angles.mean(axis=1))])


def body_frame(model: Model, vertices: Floats) -> Floats:
    """Chains (R, N, 2) moved to the body frame."""
    poses = body_poses(model, vertices)
    c, s = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
    x, y = np.moveaxis(vertices - poses[:, None, :2], 2, 0)
    return np.stack([c * x + s * y, c * y - s * x], axis=2)
