"""Shapes and poses of a body that only its tracked points show, smoothed in time, and what their noise may be.

Joint angles are those between the directions of the recorded links, so that a picture that breathes does not bend the
body; they are smoothed as bends of the whole body (`serpenoid.measure.shapes.principal_bends`). Poses lay the smooth
chain over the points. All is smoothed by local cubics whose width generalised cross-validation picks: no noise needs to
be known beforehand,
    GCV(K) = R |z - H_K z|^2 / (R - tr H_K)^2,   R frames, K of them in a window.
What smoothing takes out is the noise: frame by frame drawn again, put on and smoothed it gives draws of the states (the
bootstrap of residuals).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from serpenoid.body import Body, Floats
from serpenoid.diagnose.data.shapes.geometry import placed, register, shapes
from serpenoid.errors import InputError
from serpenoid.measure.clock import bridged, unwrapped
from serpenoid.measure.shapes.chain import estimate_chain
from serpenoid.measure.shapes.links import marker_angles
from serpenoid.measure.shapes.principal_bends import LEAST_LEFT, BendFinder
from serpenoid.measure.shapes.smooth import WINDOWS, Smoother, cross_validated, own_weights, smooth


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
        """Time scale of the bending [s]: 2 pi rms(angle) / rms(rate); that of a wave, its period, of a shape that stays
        as it is infinite."""
        moving = self.angles - self.angles.mean(axis=0)
        rate = np.gradient(moving, self.time, axis=0)
        quick = (rate**2).mean()
        return float(2 * np.pi * np.sqrt((moving**2).mean() / quick)) if quick > 0 else np.inf


@dataclass(frozen=True)
class Smoothed:
    """Smooth states, and what smoothing took out of poses (F, 3) and angles (F, m), at the size of the noise."""

    states: States
    pose_noise: Floats
    angle_noise: Floats
    poses_by: Smoother
    bends: BendFinder

    def draw(self, rng: np.random.Generator) -> States:
        """States as another recording of the same motion might show them: shapes that err are laid over the points."""
        count, s = len(self.states.time), self.states
        order = rng.integers(count, size=count)
        noisy = s.angles + self.angle_noise[order]
        angles = self.bends.bends(noisy).smoothed(noisy)
        points = placed(shapes(s.body, s.angles), s.poses)
        laid = register(shapes(s.body, angles), points)[0]
        return States(s.body, s.time, smooth(laid + self.pose_noise[order], *self.poses_by), angles)


def from_points(body: Body, time: Floats, markers: Floats, near: Floats) -> Smoothed:
    """Smooth states of points (F, N, 2) [m]; near (F, N, 2): a smooth chain about which angles are linear in the
    points, whatever their noise, and which has the bends that hidden points do not show."""
    rows = np.arange(float(len(markers)))
    shown = angles_about(body, near, markers)
    angles = np.where(np.isfinite(shown), shown, unwrapped(marker_angles(body, near)))
    finder = BendFinder.of(body, time)
    bends = finder.bends(angles)
    smooth_angles = bends.smoothed(angles)
    poses = bridged(rows, register(shapes(body, smooth_angles), markers)[0])
    smooth_poses, pose_noise, poses_by = _smoothed(time, poses, np.array([1.0, 1.0, body.total_length_m / 4]))
    states = States(body, time, smooth_poses, smooth_angles)
    return Smoothed(states, pose_noise, bends.noise(angles), poses_by, finder)


def angles_about(body: Body, near: Floats, markers: Floats) -> Floats:
    """Joint angles (F, m) between the links that markers (F, N, 2) show, to first order about those of a chain that is
    near them (F, N, 2); continuous in time, NaN where an end of a link is hidden."""
    there, seen = (np.diff(points[:, body.corners], axis=1) for points in (near, markers))
    turned = (there[..., 0] * seen[..., 1] - there[..., 1] * seen[..., 0]) / (there**2).sum(axis=2)
    return np.asarray(unwrapped(marker_angles(body, near)) + np.diff(turned, axis=1))


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


def _smoothed(time: Floats, values: Floats, scale: Floats) -> tuple[Floats, Floats, Smoother]:
    """Smooth columns (F, c), noise (F, c) and what smooths best; scale (c,): what counts as much."""
    by = cross_validated(time, values, scale)
    if by is None:
        raise ValueError(f"{len(time)} frames are too few to be smoothed.")
    steady = smooth(values, *by)
    return steady, (values - steady) / np.sqrt(np.maximum(1 - own_weights(by), LEAST_LEFT))[:, None], by
