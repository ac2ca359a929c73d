"""What the noise of shapes does to a fit beyond first order: the fit done again on recordings made from its own answer.

The likelihood is linear about the smooth path z~, which is off by d: by noise that smoothing leaves, by bends that it
flattens. What this does to the defects goes with the square of d, the same way in every frame, so it does not average
out. Nobody knows d, but what would become of z~ itself, were it the truth, can be tried:

    z = z~, its poses moved as the fitted model says;    z^_b = z +- n_b,  n_b ~ N(0, C - C P C);    z~_b = S z^_b
    shift_b = fitted to (z^_b, z~_b) - fitted before     = odd_b + even_b of +n_b and -n_b

with S what smoothed z^. The mean of even_b is the fit's bias, which is taken away. odd_b less what it is to first order
(a fit about z itself, the variance that is stated already), and the scatter of even_b, are errors that come on top.
P: see `likelihood._unseen`. An animal's points are close together: their noise is a large part of a bend.

Legend: R rows, m joints, P fitted parameters, B pairs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from serpenoid import group
from serpenoid.body import Floats
from serpenoid.compare.likelihood import Segment, Solution, Whitened, believed, whiten, whitened
from serpenoid.compare.linearise import Linearised, linearise, relative_poses
from serpenoid.compare.parameters import changed, direction
from serpenoid.measure.principal_bends import bends_smoother
from serpenoid.model import Model

PAIRS = 8  # the bias is known to a third of the scatter that is counted anyway


def redrawn(model: Model, segments: tuple[Segment, ...], solution: Solution) -> tuple[Floats, Floats]:
    """Bias (P,) of an animal's fit, and the standard error (P,) that comes to that of first order; zeros of others."""
    if not model.body.is_animal or not solution.names:
        return np.zeros(len(solution.values)), np.zeros(len(solution.values))
    fitted = changed(model, solution.names, solution.values)
    along = direction(fitted, solution.names, solution.values)
    truths, linears = zip(*(_truth(fitted, segment) for segment in segments), strict=True)
    roots = [_root(fitted, segment) for segment in segments]
    generator = np.random.default_rng(0)
    even, odd = [], []
    for _ in range(PAIRS):
        noises = [np.einsum("rij,rj->ri", root, generator.normal(size=root.shape[:2])) for root in roots]
        up, down = (
            [_moved(truth, sign * noise) for truth, noise in zip(truths, noises, strict=True)] for sign in (1.0, -1.0)
        )
        first_order = _shift([whitened(lin, s, along, lin) for lin, s in zip(linears, up, strict=True)])
        above, below = (
            _shift(whiten(fitted, tuple(map(_smoothed, drawn)), solution.names, solution.values))
            for drawn in (up, down)
        )
        even.append((above + below) / 2)
        odd.append((above - below) / 2 - first_order)
    more = np.mean(np.square(odd), axis=0) + np.var(even, axis=0, ddof=1) * (1 + 1 / PAIRS)
    return np.mean(even, axis=0), np.sqrt(more)


def _truth(model: Model, segment: Segment) -> tuple[Segment, Linearised]:
    """The segment's smooth shapes and the poses that the model moves them through, without noise; the steps there."""
    shapes, weights = segment.smooth_angles, segment.weights
    steps = relative_poses(segment.smooth_poses) - linearise(model, shapes, segment.smooth_poses, weights).defect
    poses = group.accumulate(steps, segment.smooth_poses[0])
    truth = replace(segment, poses=poses, smooth_poses=poses, joint_angles=shapes)
    return truth, linearise(model, shapes, poses, weights)


def _root(model: Model, segment: Segment) -> Floats:
    """Of the covariance (R, 3 + m, 3 + m) that estimates have about the truth."""
    along = believed(model, segment)
    values, vectors = np.linalg.eigh(segment.covariance - along @ along.transpose(0, 2, 1))
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0))[:, None])


def _moved(truth: Segment, noise: Floats) -> Segment:
    return replace(truth, poses=truth.poses + noise[:, :3], joint_angles=truth.joint_angles + noise[:, 3:])


def _smoothed(drawn: Segment) -> Segment:
    """About its own smooth shapes, whose windows are picked anew: which bends noise hides is chance, too."""
    smoother = bends_smoother(drawn.time_s, drawn.joint_angles, drawn.covariance[:, 3:, 3:])
    return replace(drawn, smooth_angles=smoother(drawn.joint_angles))


def _shift(left: Sequence[Whitened]) -> Floats:
    """Of the fitted numbers (P,), by one Gauss-Newton step."""
    jacobian = np.concatenate([w.by_parameters.reshape(w.defect.size, -1) for w in left])
    return -np.linalg.lstsq(jacobian, np.concatenate([w.defect.ravel() for w in left]), rcond=None)[0]
