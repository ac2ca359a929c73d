"""What a law that is wrong leaves open about a value: gaits disagree, and so do explanations of what the law misses.

    theta_g = theta + u_g,   u_g ~ N(0, T),   T = diag(tau^2 s^2)

theta_g: what gait g tells, u_g: the law's error there. A law errs in proportion to what it does (discrepancy.py): an
effect's coordinate is off by what would change windows by a share tau of what the effect does, s_i = |E| / |J_i|; eps
by a share of itself. The two shares are those of restricted maximum likelihood, the random effects of a meta-analysis
(DerSimonian and Laird, Controlled Clinical Trials 7, 177, 1986). An error that all gaits have in common is not seen by
comparing them; it is expected to be as large as what they do not share, so T counts once more (the prediction interval
of Higgins, Thompson and Spiegelhalter, J. R. Stat. Soc. A 172, 137, 2009). What one explanation of an earlier campaign
says of the change, another one does not, nor what stands beside it below detection: the scatter of values is added,
each explanation weighed by the inverse of what it left of the earlier campaign, and by how likely this one is with it:
its gaits are the independent numbers, of unknown scale, so that is chi squared to the power -G / 2.

Legend: G gaits, P coordinates (eps first), K explanations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from serpenoid.body import Floats
from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.inference.evidence import SILENT
from serpenoid.diagnose.inference.medium import Fit, linearised, predicted_bare

STARTS = ((-12.0, -12.0), (-6.0, -6.0), (-2.0, -2.0))  # ln tau^2, of eps and of effects
SMALLEST, LARGEST = -20.0, 6.0


Coordinate = tuple[str, int | None, int]  # an effect's name and place, and which of its coordinates


@dataclass(frozen=True)
class Doubted:
    """A value and its standard deviation, the law's error included."""

    value: float
    deviation: float


def doubted(explained: Sequence[tuple[Motion, Fit, float]], hold: bool = True) -> dict[Coordinate, Doubted]:
    """Of every coordinate, fitted beside one or more explanations of what the law misses, each with its weight.

    hold: what ended at a bound stays there.
    """
    found: dict[Coordinate, list[tuple[Doubted, float]]] = {}
    left = [fit.chi2 / float(fit.evidence.count.sum()) for _, fit, _ in explained]
    for (motion, fit, earlier), mine in zip(explained, left, strict=True):
        weight = earlier * (min(left) / mine) ** (len(set(motion.labels)) / 2)
        names = [(e.name, e.place, i) for e in fit.effects for i in range(len(e.effect.parameters))]
        values, deviations = of_gaits(motion, fit, hold)
        for name, value, deviation in zip(names, values[1:], deviations[1:], strict=True):
            found.setdefault(name, []).append((Doubted(float(value), float(deviation)), weight))
    return {name: _together(several) for name, several in found.items()}


def _together(several: Sequence[tuple[Doubted, float]]) -> Doubted:
    count, weights = len(several), np.array([weight for _, weight in several])
    values, variances = np.array([d.value for d, _ in several]), np.array([d.deviation**2 for d, _ in several])
    mean = float(np.average(values, weights=weights))
    between = float(np.average((values - mean) ** 2, weights=weights)) * count / max(count - 1, 1)
    return Doubted(mean, float(np.sqrt(np.average(variances, weights=weights) + between)))


def of_gaits(motion: Motion, fit: Fit, hold: bool = True) -> tuple[Floats, Floats]:
    """Coordinates (P,) of one fit and their deviations, to first order about it; hold: see `doubted`."""
    own = len(fit.coordinates)
    inflated = max(1.0, fit.chi2 / float(fit.evidence.count.sum()))
    loose = linearised(motion, fit.model, fit.effects, near=fit.predictions, hold=False)[0] if not hold else None
    evidence = loose or fit.evidence
    matrix, vector = evidence.matrix[:, :own, :own], evidence.vector[:, :own]
    scale = _in_proportion(motion, fit, np.diag(matrix.sum(axis=0)))
    moved, spread = with_errors_of_gaits(matrix / inflated, vector / inflated, scale)
    return fit.coordinates + moved, spread


def with_errors_of_gaits(matrix: Floats, vector: Floats, scale: Floats) -> tuple[Floats, Floats]:
    """How far all gaits together move the coordinates (P,) if each has an error of its own, and deviations (P,).

    matrix (G, P, P), vector (G, P): of chi squared, in units of what is left; scale (P,): of the errors, 0 where the
    data are silent. The first coordinate is eps.
    """
    speaks = np.flatnonzero(scale > 0)
    size, effect = scale[speaks], (speaks > 0).astype(int)
    a, b = matrix[:, speaks[:, None], speaks] * np.outer(size, size), vector[:, speaks] * size

    def deviance(log: Floats) -> float:
        return _restricted(a, b, np.exp(log)[effect])[0]

    bounds = [(SMALLEST, LARGEST)] * 2
    best = min((minimize(deviance, x, method="Nelder-Mead", bounds=bounds) for x in STARTS), key=lambda o: o.fun)
    variance = np.exp(best.x)[effect]
    _, mean, covariance = _restricted(a, b, variance)
    moved, spread = np.zeros(len(scale)), np.zeros(len(scale))
    moved[speaks], spread[speaks] = mean * size, np.sqrt(np.diag(covariance) + variance) * size
    return moved, spread


def _restricted(matrix: Floats, vector: Floats, variance: Floats) -> tuple[float, Floats, Floats]:
    """-2 ln of the restricted likelihood but for a constant, the mean of all gaits (P,) and its covariance.

    matrix (G, P, P), vector (G, P): chi squared of each gait; variance (P,): of what differs between gaits.
    """
    same = np.eye(len(variance))
    inverse = np.linalg.inv(same + matrix * variance)  # (1 + A T)^-1
    weight, pull = (inverse @ matrix).sum(axis=0), (inverse @ vector[..., None])[..., 0]
    covariance = np.linalg.inv(weight + SILENT * same)
    mean = covariance @ pull.sum(axis=0)
    explained = float((vector * variance * pull).sum()) + float(pull.sum(axis=0) @ mean)
    size = -float(np.linalg.slogdet(inverse)[1].sum()) - float(np.linalg.slogdet(covariance)[1])
    return size - explained, mean, covariance


def _in_proportion(motion: Motion, fit: Fit, curvature: Floats) -> Floats:
    """Change of each coordinate (P,) that is worth, in the windows, as much as the effects do; 0 of what is silent."""
    bare = predicted_bare(motion, fit) if fit.effects else fit.predictions
    done = 0.0
    for track, white, p, q in zip(motion.tracks, motion.white, fit.predictions, bare, strict=True):
        moved = p.displacement - q.displacement
        done += float((white.of(moved, track.usable & np.isfinite(moved).all(axis=1)) ** 2).sum())
    scale = np.sqrt(np.divide(done, curvature, out=np.zeros(len(curvature)), where=curvature > SILENT))
    scale[0] = fit.coordinates[0] if curvature[0] > SILENT else 0.0
    return np.asarray(scale)
