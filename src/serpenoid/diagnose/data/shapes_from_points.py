"""Shapes and poses of a body that only its tracked points show, smoothed in time, and what their noise may be.

Joint angles are those between the directions of the recorded links, so that a picture that breathes does not bend the
body; poses lay the chain over the points. Both are smoothed by local cubics whose width generalised cross-validation
picks: no noise needs to be known beforehand,
    GCV(K) = R |z - H_K z|^2 / (R - tr H_K)^2,   R frames, K of them in a window.
What smoothing takes out is the noise: shuffled in time, put on again and smoothed again it gives draws of the states.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from serpenoid.body import Body, Floats
from serpenoid.diagnose.data.geometry import register, shapes
from serpenoid.errors import InputError
from serpenoid.measure.chain import estimate_chain
from serpenoid.measure.clock import bridged, unwrapped
from serpenoid.measure.links import marker_angles
from serpenoid.measure.smooth import WINDOWS, cross_validated, smooth


@dataclass(frozen=True)
class States:
    """time (F,) [s], poses (F, 3) [m, rad], angles (F, m) [rad], continuous in time between the frames."""

    body: Body
    time: Floats
    poses: Floats
    angles: Floats

    def poses_at(self, time: Floats) -> Floats:
        """(R, 3)."""
        return np.asarray(CubicSpline(self.time, self.poses)(time))

    def vertices_at(self, time: Floats) -> Floats:
        """Vertices (R, N, 2) [m] in the body frame."""
        return shapes(self.body, CubicSpline(self.time, self.angles)(time))

    @property
    def period(self) -> float:
        """Time scale of the bending [s]: 2 pi rms(angle) / rms(rate); that of a wave, its period."""
        moving = self.angles - self.angles.mean(axis=0)
        rate = np.gradient(moving, self.time, axis=0)
        return float(2 * np.pi * np.sqrt((moving**2).mean() / (rate**2).mean()))


@dataclass(frozen=True)
class Smoothed:
    """Smooth states, and what smoothing took out of poses (F, 3) and angles (F, m), at the size of the noise."""

    states: States
    pose_noise: Floats
    angle_noise: Floats
    pose_weights: tuple[Floats, np.ndarray]
    angle_weights: tuple[Floats, np.ndarray]

    def draw(self, rng: np.random.Generator) -> States:
        """States as another recording of the same motion might show them."""
        order = rng.permutation(len(self.states.time))
        s = self.states
        return States(
            s.body, s.time, smooth(s.poses + self.pose_noise[order], *self.pose_weights),
            smooth(s.angles + self.angle_noise[order], *self.angle_weights),
        )  # fmt: skip


def from_points(body: Body, time: Floats, markers: Floats) -> Smoothed:
    """Smooth states of points (F, N, 2) [m], short holes bridged."""
    rows = np.arange(float(len(markers)))
    angles = bridged(rows, unwrapped(marker_angles(body, markers)))
    poses = bridged(rows, register(shapes(body, angles), markers)[0])
    smooth_poses, pose_noise, pose_weights = _smoothed(time, poses, np.array([1.0, 1.0, body.total_length_m / 4]))
    smooth_angles, angle_noise, angle_weights = _smoothed(time, angles, np.ones(angles.shape[1]))
    return Smoothed(
        States(body, time, smooth_poses, smooth_angles), pose_noise, angle_noise, pose_weights, angle_weights
    )


def angles_shown(body: Body, markers: Floats) -> tuple[NDArray[np.bool_], Floats]:
    """Frames (F,) whose markers (F, N, 2) [m] determine the shape under rigid links, and their joint angles (R, m)."""
    chain = estimate_chain(body, markers / body.total_length_m)
    if chain.determined.sum() < WINDOWS[1]:
        raise InputError(
            "in too few frames are enough markers seen to know the body's shape, and there is no servo log."
        )
    return chain.determined, chain.joint_angles[chain.determined]


def angles_read(body: Body, markers: Floats, known: NDArray[np.bool_], shapes_known: Floats) -> Floats:
    """What markers (F, N, 2) [m] show of the joint angles (F, m): where a shape is known as a whole (`angles_shown`) by
    all links together. NaN about a vertex that is hidden: rigid links leave two mirror positions to it, or, nearly
    straight, any between."""
    found = marker_angles(body, markers)
    found[known] = np.where(np.isfinite(found[known]), shapes_known, np.nan)
    return found


def _smoothed(time: Floats, values: Floats, scale: Floats) -> tuple[Floats, Floats, tuple[Floats, np.ndarray]]:
    """Smooth columns (F, c), noise (F, c) and the weights of the best window; scale (c,): what counts as much."""
    found = cross_validated(time, values, scale)
    if found is None:
        raise ValueError(f"{len(time)} frames are too few to be smoothed.")
    weights, rows = found
    steady = smooth(values, weights, rows)
    own = weights[rows == np.arange(len(time))[:, None]]
    return steady, (values - steady) / np.sqrt(np.maximum(1 - own, 0.05))[:, None], (weights, rows)
