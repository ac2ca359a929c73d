"""Maximum likelihood with noisy shapes: measured states z^ with covariance C, step equations as exact constraints.

    e(z_r, z_{r+1}; theta) = 0 at the true states z;  z^ = z + noise, noise ~ N(0, C)
    e^ = e(z~; theta) + G (z^ - z~) ~ N(0, S),  S = G C G',  G = de/dz at a smooth path z~ through the measured states
    minimise  e^' S^-1 e^  over theta by Gauss-Newton,  J = de/dtheta at z~

S is block tridiagonal: a row's noise enters the step before it and the step after it, pose and shape together, and the
sums telescope. Taking G and J at z~ and not at z^ keeps two second-order effects out: products of shape noise (a random
walk of its own once integrated) and noise in J (errors in variables, which would pull theta towards zero). z~ may be
off: e^ is wrong only by the square of its error. Source: Britt & Luecke, Technometrics 15, 1973;
docs/measuring-method.md.

Legend: R rows, S = R - 1 steps, m joints, P fitted parameters, q = 3 + m.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky_banded, solve_banded

from serpenoid.body import Floats
from serpenoid.body_curve import SMOOTH
from serpenoid.compare.linearise import Linearised, linearise
from serpenoid.compare.parameters import bounds, changed, direction
from serpenoid.measure.shapes.chain import VAGUE_SD
from serpenoid.measure.shapes.links import link_directions
from serpenoid.model import Model

ITERATIONS = 40
NEAR = 1e-3  # of a covariance: its log determinant's slope by differences is exact to the square of this
BAND = 5  # block-tridiagonal with 3 x 3 blocks


@dataclass(frozen=True)
class Segment:
    """Successive measured rows: times (R,), joint angles (R, m), poses (R, 3), covariance of both (R, q, q)."""

    time_s: Floats
    joint_angles: Floats
    poses: Floats
    covariance: Floats
    smooth_angles: Floats  # z~
    smooth_poses: Floats
    weights: Floats  # (N,) of the recorded body: poses are of its centroid
    trial: str = ""
    phase: Floats | None = None  # (R,) cycles
    markers: Floats | None = None  # (R, N, 2) that the states were estimated from, NaN hidden
    marker_sd: float = 0.0


@dataclass(frozen=True)
class Whitened:
    """A segment's defects made white (unit variance, independent): (S, 3), and their derivative (S, 3, P)."""

    defect: Floats
    by_parameters: Floats


@dataclass(frozen=True)
class Solution:
    """Fitted values, covariance (P, P) for unit noise scale, chi2, what noise makes of it, and what is left."""

    names: tuple[str, ...]
    values: Floats
    covariance: Floats
    chi2: float
    freedom: int
    segments: tuple[Whitened, ...]
    converged: bool

    @property
    def noise_scale(self) -> float:
        """sqrt(chi2 / freedom): 1 where the measurement noise explains everything that is left."""
        return float(np.sqrt(self.chi2 / max(self.freedom, 1)))


def fit(
    model: Model, segments: tuple[Segment, ...], names: tuple[str, ...], start: Floats, noise: Model | None = None
) -> Solution:
    """Fit the named numbers to all segments at once. `names` may be empty: then the model is only judged.

    `noise`: the model at which S is evaluated, where values of chi2 are to be compared; default: the current one.
    """
    values = np.asarray(start, float).copy()
    low, high = bounds(names, model) if names else (values, values)
    converged = not names
    for _ in range(ITERATIONS if names else 0):
        information, gradient, _ = _normal_equations(whiten(model, segments, names, values, noise))
        step = -np.linalg.lstsq(information, gradient, rcond=1e-14)[0]
        reach = np.maximum(0.5 * np.abs(values), 0.05)
        moved = np.clip(values + np.clip(step, -reach, reach), low, high)
        step, values = moved - values, moved
        if (np.abs(step) <= 1e-9 + 1e-3 * np.sqrt(np.abs(np.diag(np.linalg.pinv(information))))).all():
            converged = True
            break
    left = whiten(model, segments, names, values, noise)
    information, _, chi2 = _normal_equations(left)
    judged = changed(model, names, values) if noise is None else noise
    unseen = sum(_unseen(judged, segment) for segment in segments)
    freedom = sum(w.defect.size for w in left) - round(unseen) - len(names)
    return Solution(names, values, np.asarray(np.linalg.pinv(information)), chi2, freedom, left, converged)


def whiten(
    model: Model,
    segments: tuple[Segment, ...],
    names: tuple[str, ...],
    values: Floats,
    noise: Model | None = None,
    degree: int = SMOOTH,
) -> tuple[Whitened, ...]:
    """White defects of every segment, and their derivative, at given numbers; degree: see `simulate_curve`."""
    current = changed(model, names, values)
    along = direction(model, names, values) if names else np.zeros((2 * model.body.vertices, 0))
    return tuple(_whiten(current, segment, along, noise, degree) for segment in segments)


def _normal_equations(left: tuple[Whitened, ...]) -> tuple[Floats, Floats, float]:
    """J' J, J' e and e' e of the white defects."""
    jacobian = np.concatenate([w.by_parameters.reshape(w.defect.size, w.by_parameters.shape[2]) for w in left])
    defect = np.concatenate([w.defect.ravel() for w in left])
    return jacobian.T @ jacobian, jacobian.T @ defect, float(defect @ defect)


def _whiten(model: Model, segment: Segment, along: Floats, noise: Model | None, degree: int) -> Whitened:
    lin = linearise(model, segment.smooth_angles, segment.smooth_poses, segment.weights, degree)
    spread = lin if noise is None else linearise(noise, segment.smooth_angles, segment.smooth_poses, segment.weights)
    return whitened(lin, segment, along, spread)


def whitened(lin: Linearised, segment: Segment, along: Floats, spread: Linearised) -> Whitened:
    """A segment's white defects, linear about its smooth path; along (2 N, P): of the parameters; spread: of S."""
    pose_away = segment.poses - segment.smooth_poses
    away = np.concatenate([pose_away, segment.joint_angles - segment.smooth_angles], axis=1)
    shifted = np.einsum("siq,sq->si", lin.by_before, away[:-1]) + np.einsum("siq,sq->si", lin.by_after, away[1:])
    lower = cholesky_banded(_banded(spread, segment.covariance), lower=True)
    right = np.concatenate([(lin.defect + shifted)[..., None], lin.by_parameters @ along], axis=2)
    white = np.asarray(solve_banded((BAND, 0), lower, right.reshape(-1, right.shape[2]))).reshape(right.shape)
    return Whitened(white[..., 0], white[..., 1:])


def _unseen(model: Model, segment: Segment) -> float:
    """By how much chi2 is expected to be smaller than its count of numbers, because what nothing measured has no error.

    A direction that is known to VAGUE_SD beforehand, and by nothing else, is in C, but stays where the smooth path is:
    estimates scatter by C - C P C (P: what was believed), so <chi2> = tr S^-1 (S - G C P C G') = size - d ln|S| / dt
    along S + t G C P C G'.
    """
    lin = linearise(model, segment.smooth_angles, segment.smooth_poses, segment.weights)
    unit = np.eye(segment.covariance.shape[1])
    believed = segment.covariance @ link_directions(model.body, unit[:, :3], unit[:, 3:]) / VAGUE_SD
    spread, along = _banded(lin, segment.covariance), _banded(lin, believed @ believed.transpose(0, 2, 1))
    more, less = (_log_determinant(spread + step * along) for step in (NEAR, -NEAR))
    return (more - less) / (2 * NEAR)


def _log_determinant(band: Floats) -> float:
    return 2 * float(np.log(cholesky_banded(band, lower=True)[0]).sum())


def _banded(lin: Linearised, covariance: Floats) -> Floats:
    """S = G C G' in lower banded storage, shape (6, 3 S)."""
    before, after = lin.by_before, lin.by_after
    diagonal = before @ covariance[:-1] @ before.transpose(0, 2, 1) + after @ covariance[1:] @ after.transpose(0, 2, 1)
    below = before[1:] @ covariance[1:-1] @ after[:-1].transpose(0, 2, 1)  # rows of step r + 1, columns of step r
    steps = len(diagonal)
    band = np.zeros((BAND + 1, 3 * steps))
    for column in range(3):
        for row in range(column, 3):
            band[row - column, column::3] = diagonal[:, row, column]
        for row in range(3):
            band[3 + row - column, column : 3 * (steps - 1) : 3] = below[:, row, column]
    return band
