"""SE(2) by numbers: poses (x, y, heading) and how relative motions compose. Shapes: (..., 3).

And poses in space, (x, y, heading, z, pitch, roll), see `objectives.frames`: to and from places and rotations.
"""

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


def spatial_rotation(poses: Floats) -> Floats:
    """Rotation matrices (..., 3, 3) of poses in space (..., 6)."""
    (c, s), (cp, sp), (cr, sr) = ((np.cos(poses[..., i]), np.sin(poses[..., i])) for i in (2, 4, 5))
    rows = [
        [c * cp, c * sp * sr - s * cr, c * sp * cr + s * sr],
        [s * cp, s * sp * sr + c * cr, s * sp * cr - c * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.stack([np.stack(row, -1) for row in rows], -2)


def spatial_poses(rotations: Floats, places: Floats) -> Floats:
    """Poses in space (..., R, 6) of successive frames: rotations (..., R, 3, 3), places (..., R, 3); headings count
    turns."""
    heading = np.unwrap(np.arctan2(rotations[..., 1, 0], rotations[..., 0, 0]), axis=-1)
    pitch = -np.arcsin(np.clip(rotations[..., 2, 0], -1, 1))
    roll = np.arctan2(rotations[..., 2, 1], rotations[..., 2, 2])
    return np.stack([places[..., 0], places[..., 1], heading, places[..., 2], pitch, roll], -1)
