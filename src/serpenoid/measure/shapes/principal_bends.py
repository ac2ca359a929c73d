"""Joint angles as a few bends of the whole body, each smoothed by itself: noise of close points is most of every joint
angle and little of any such bend.

    angles = mean + bends B,     B: principal components of the angles in units of their noise

In these units noise is alike in all directions, so the first components are bends and the others noise alone. Every
one has the window of local cubics that generalised cross-validation picks, or its mean where that predicts no worse:
neither the size of the noise nor how many bends a body has need be known (where it is: Cp, `bends_smoother`). Of noise
only the pattern enters:

    joint angle j = n . (p_{j+1} - p_j) / l_{j+1} - n . (p_j - p_{j-1}) / l_j      n: across the body, p: points,

l the links' lengths, alike for all points.

Legend: R frames, m joints.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Body
from serpenoid.measure.blocks import blocks
from serpenoid.measure.cells import Floats
from serpenoid.measure.shapes.smooth import (
    Smoother,
    own_weights,
    scored_windows,
    smooth,
    smooth_states,
    smoother,
    smoothers,
)

LEAST_LEFT = 0.05  # of a value's variance: beyond, what smoothing leaves says nothing of its noise


@dataclass(frozen=True)
class PrincipalBends:
    """mean (m,), of_angles (m, m) and to_angles (m, m): bends of angles, and back; windows: what smooths some of the
    bends, all others have their mean."""

    mean: Floats
    of_angles: Floats
    to_angles: Floats
    windows: tuple[tuple[NDArray[np.bool_], Smoother], ...]

    def smoothed(self, angles: Floats) -> Floats:
        """Angles (R, m) of the frames that the windows were picked for, smoothed."""
        return self.mean + self._smooth(self._bends(angles)) @ self.to_angles

    def noise(self, angles: Floats) -> Floats:
        """What smoothing takes out of angles (R, m), at the size of the noise."""
        bends = self._bends(angles)
        left = np.sqrt(np.maximum(1 - self._own(bends), LEAST_LEFT))
        return np.asarray((bends - self._smooth(bends)) / left @ self.to_angles)

    def _bends(self, angles: Floats) -> Floats:
        return (angles - self.mean) @ self.of_angles

    def _smooth(self, bends: Floats) -> Floats:
        found = np.repeat(bends.mean(axis=0)[None], len(bends), axis=0)
        for these, by in self.windows:
            found[:, these] = smooth(bends[:, these], *by)
        return found

    def _own(self, bends: Floats) -> Floats:
        """Weight (R, m) of each frame in its own smoothed value."""
        found = np.full_like(bends, 1 / len(bends))
        for these, by in self.windows:
            found[:, these] = own_weights(by)[:, None]
        return found


@dataclass(frozen=True)
class BendFinder:
    """Finds the bends of a body in recordings of the same frames. root (m, m): of the pattern of noise."""

    root: Floats
    smoothers: tuple[Smoother, ...]

    @classmethod
    def of(cls, body: Body, time_s: Floats) -> BendFinder:
        """Of a body's frames at times (R,) [s]."""
        return cls(np.asarray(np.linalg.cholesky(noise_pattern(body))), smoothers(time_s))

    def bends(self, angles: Floats) -> PrincipalBends:
        """Of joint angles (R, m) that points of the body show."""
        mean = angles.mean(axis=0)
        of_angles, to_angles = _axes(self.root, angles - mean)
        best = self._best((angles - mean) @ of_angles)
        windows = [(best == i, by) for i, by in enumerate(self.smoothers) if (best == i).any()]
        return PrincipalBends(mean, of_angles, to_angles, tuple(windows))

    def _best(self, bends: Floats) -> NDArray[np.int64]:
        """Index (m,) of the smoother that predicts each bend (R, m) best; -1: its mean does."""
        count = len(bends)
        scores = [(bends**2).sum(axis=0) / (count - 1) ** 2]
        for by in self.smoothers:
            left = bends - smooth(bends, *by)
            scores.append((left**2).sum(axis=0) / (count - own_weights(by).sum()) ** 2)
        return np.argmin(scores, axis=0) - 1


def smooth_curves(time_s: Floats, poses: Floats, joint_angles: Floats, covariance: Floats) -> tuple[Floats, Floats]:
    """Smoothed poses (R, 3) and joint angles (R, m) of a curve through points, by `bends_smoother`."""
    smooth_poses, _ = smooth_states(time_s, poses, joint_angles[:, :0], covariance[:, :3, :3])
    return smooth_poses, bends_smoother(time_s, joint_angles, covariance[:, 3:, 3:])(joint_angles)


def shown_bends(joint_angles: Floats, covariance: Floats) -> Floats:
    """Bends (R, m) of the whole body that joint angles show, in units of their noise, which is known (R, m, m)."""
    of_angles, _, mean = _principal(joint_angles, covariance)
    return np.asarray((joint_angles - mean) @ of_angles)


def _principal(joint_angles: Floats, covariance: Floats) -> tuple[Floats, Floats, Floats]:
    """Bends of angles (m, m) and back in units of the usual frame's noise, and the mean angles (m,)."""
    size, mean = np.trace(covariance, axis1=1, axis2=2), joint_angles.mean(axis=0)
    root = np.linalg.cholesky(covariance[np.argsort(size)[len(size) // 2]])
    return *_axes(root, joint_angles - mean), mean


def bends_smoother(time_s: Floats, joint_angles: Floats, covariance: Floats) -> Callable[[Floats], Floats]:
    """What smooths joint angles (R, m) like these, whose noise (R, m, m) is known: each bend has the window that Cp
    picks, and where Cp picks none of them, its mean."""
    of_angles, to_angles, mean = _principal(joint_angles, covariance)
    bends = (joint_angles - mean) @ of_angles
    variance = np.empty_like(bends)
    for b in blocks(len(variance)):
        variance[b] = ((of_angles.T @ covariance[b]) * of_angles.T).sum(axis=2)
    picked = scored_windows(time_s, [(bends[:, k, None], variance[:, k, None]) for k in range(bends.shape[1])])
    moves = np.array([score for score, _ in picked]) < (bends**2 / variance).sum(axis=0) + 2
    best = np.where(moves, [window for _, window in picked], 0)
    windows = [(best == w, smoother(time_s, int(w))) for w in np.unique(best) if w]
    return PrincipalBends(mean, of_angles, to_angles, tuple(windows)).smoothed


def _axes(root: Floats, angles: Floats) -> tuple[Floats, Floats]:
    """Bends of angles (m, m) about their mean (R, m), and back; root (m, m): of the covariance of their noise."""
    principal = np.linalg.svd(np.linalg.solve(root, angles.T).T, full_matrices=False)[2]
    return np.linalg.solve(root.T, principal.T), principal @ root.T


def noise_pattern(body: Body) -> Floats:
    """Covariance (m, m) of joint angles, per variance of a point over the square of a body length."""
    links = np.diff(np.concatenate([[0.0], np.cumsum(body.edges)])[body.corners])
    directions = np.diff(np.eye(len(links) + 1), axis=0) / links[:, None]
    angles = np.diff(directions, axis=0)
    return np.asarray(angles @ angles.T)
