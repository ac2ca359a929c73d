"""What the noise of shapes does to a fit beyond first order: the fit done again on recordings made from its own answer.

The likelihood is linear about the smooth path z~, which is off by d: by noise that smoothing leaves, by bends that it
flattens. What this does to states and defects goes with the square of d, the same way in every frame, so it does not
average out. Nobody knows d, but what would become of z~ itself, were it the truth, can be tried:

    truth = z~, its poses moved as the fitted model says;     points_b = points(truth) +- noise_b
    z^, z~ of points_b: as of those that were filmed (`measure.trial`), windows picked anew
    shift_b = fitted to these - fitted before

SD^2 is the mean square of shift_b less what it is to first order (states and defects linear about the truth: the
variance that is stated already). The mean, which is a bias, is in it and not taken away from the fit: measured, it is
1.2 to 2.2 times the true one with noise of 2 to 4 % of the distance between points, and five times that with 13 %.
Animals only: their points are close together, and noise is a large part of a bend.

Legend: R rows, N vertices, P fitted parameters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from serpenoid import group
from serpenoid.body import Body, Floats
from serpenoid.compare.likelihood import Segment, Solution, Whitened, whiten, whitened
from serpenoid.compare.linearise import Linearised, linearise, relative_poses
from serpenoid.compare.parameters import changed, direction
from serpenoid.measure.shapes.chain import estimate_about
from serpenoid.measure.shapes.links import link_directions, vertices_by_links
from serpenoid.measure.shapes.own_noise import own_noise
from serpenoid.measure.shapes.principal_bends import smooth_curves
from serpenoid.model import Model

DRAWS = 4  # of noise, each in four mirrors: what is odd in it does not hide what is even


def redrawn_sd(model: Model, segments: tuple[Segment, ...], solution: Solution) -> Floats:
    """Standard error (P,) of an animal's fit that comes to that of first order; zeros of others."""
    names, values, body = solution.names, solution.values, model.body
    if not body.is_animal or not names or any(segment.markers is None for segment in segments):
        return np.zeros(len(values))
    fitted = changed(model, names, values)
    along = direction(fitted, names, values)
    truths, linears = zip(*(_truth(fitted, segment) for segment in segments), strict=True)
    generator = np.random.default_rng(0)
    noises = [own_noise(t.markers, DRAWS, generator) for t in truths]
    beyond = []
    for drawn in zip(*noises, strict=True):
        for mirrored in zip(*drawn, strict=True):
            filmed = [replace(t, markers=t.markers + t.marker_sd * n) for t, n in zip(truths, mirrored, strict=True)]
            first = [_estimated(body, each) for each in filmed]
            last = tuple(_estimated(body, _smoothed(each)) for each in first)
            linear = [whitened(lin, each, along, lin) for lin, each in zip(linears, first, strict=True)]
            beyond.append(_shift(whiten(fitted, last, names, values)) - _shift(linear))
    return np.asarray(np.sqrt(np.mean(np.square(beyond), axis=0)))


def _truth(model: Model, segment: Segment) -> tuple[Segment, Linearised]:
    """The segment's smooth shapes, the poses that the model moves them through, and points there; the steps there."""
    shapes, weights = segment.smooth_angles, segment.weights
    steps = relative_poses(segment.smooth_poses) - linearise(model, shapes, segment.smooth_poses, weights).defect
    poses = group.accumulate(steps, segment.smooth_poses[0])
    points = vertices_by_links(model.body, link_directions(model.body, poses, shapes))[0]
    if segment.markers is not None:
        points = np.where(np.isfinite(segment.markers), points, np.nan)
    return replace(segment, smooth_poses=poses, markers=points), linearise(model, shapes, poses, weights)


def _estimated(body: Body, segment: Segment) -> Segment:
    """With the states that its points show, in one linear step from its smooth path."""
    if segment.markers is None:
        return segment
    found = estimate_about(body, segment.markers, segment.smooth_poses, segment.smooth_angles, segment.marker_sd)
    return replace(segment, poses=found.poses, joint_angles=found.joint_angles, covariance=found.covariance)


def _smoothed(segment: Segment) -> Segment:
    """With a smooth path of its own, whose windows are picked anew: which bends noise hides is chance, too."""
    smooth = smooth_curves(segment.time_s, segment.poses, segment.joint_angles, segment.covariance)
    return replace(segment, smooth_poses=smooth[0], smooth_angles=smooth[1])


def _shift(left: Sequence[Whitened]) -> Floats:
    """Of the fitted numbers (P,), by one Gauss-Newton step."""
    jacobian = np.concatenate([w.by_parameters.reshape(w.defect.size, -1) for w in left])
    return -np.linalg.lstsq(jacobian, np.concatenate([w.defect.ravel() for w in left]), rcond=None)[0]
