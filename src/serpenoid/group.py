"""SE(2) by numbers: poses (x, y, heading) and how relative motions compose. Shapes: (..., 3)."""

from __future__ import annotations

import numpy as np

from serpenoid.body import Floats


def rotation(heading: Floats | float) -> Floats:
    """Rotation matrices, shape (..., 2, 2)."""
    c, s = np.cos(heading), np.sin(heading)
    return np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)


def accumulate(relative: Floats, start: Floats | None = None) -> Floats:
    """Poses reached by relative motions, (..., T, 3) -> (..., T + 1, 3), beginning at `start` (default origin)."""
    first = np.zeros(3) if start is None else np.asarray(start, float)
    zero = np.zeros((*relative.shape[:-2], 1))
    heading = first[2] + np.concatenate([zero, np.cumsum(relative[..., 2], -1)], -1)
    c, s = np.cos(heading[..., :-1]), np.sin(heading[..., :-1])
    dx = c * relative[..., 0] - s * relative[..., 1]
    dy = s * relative[..., 0] + c * relative[..., 1]
    x = first[0] + np.concatenate([zero, np.cumsum(dx, -1)], -1)
    y = first[1] + np.concatenate([zero, np.cumsum(dy, -1)], -1)
    return np.stack([x, y, heading], -1)


def place(poses: Floats, points: Floats) -> Floats:
    """Body-frame points (..., N, 2) in the world: shape (..., N, 2)."""
    c, s = np.cos(poses[..., 2, None]), np.sin(poses[..., 2, None])
    x, y = points[..., 0], points[..., 1]
    placed = np.empty(np.broadcast_shapes((*poses.shape[:-1], 1, 2), points.shape))
    placed[..., 0], placed[..., 1] = c * x - s * y + poses[..., 0, None], s * x + c * y + poses[..., 1, None]
    return placed


def compose(first: Floats, second: Floats) -> Floats:
    """Poses `second` (..., 3), given in the frames of `first` (..., 3), in the frame that those are given in."""
    moved = np.einsum("...ij,...j->...i", rotation(first[..., 2]), second[..., :2])
    return np.concatenate([first[..., :2] + moved, (first[..., 2] + second[..., 2])[..., None]], -1)


def inverse(poses: Floats) -> Floats:
    """The frames that poses (..., 3) are given in, seen from those poses."""
    back = -np.einsum("...ji,...j->...i", rotation(poses[..., 2]), poses[..., :2])
    return np.concatenate([back, -poses[..., 2:]], -1)


def relative(first: Floats, second: Floats) -> Floats:
    """Poses `second` (..., 3) in the frames of poses `first` (..., 3)."""
    d = second - first
    c, s = np.cos(first[..., 2]), np.sin(first[..., 2])
    return np.stack([c * d[..., 0] + s * d[..., 1], c * d[..., 1] - s * d[..., 0], d[..., 2]], -1)
