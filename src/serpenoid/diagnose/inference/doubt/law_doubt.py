"""What a law that is wrong leaves open about a value: gaits disagree, and so do explanations of what the law misses.

    b_g = A_g theta + e_g,   e_g ~ N(0, v_g A_g),   v_g = 1 + s^2 D_g^2 + t^2 E_g^2

A_g, b_g: what the windows of gait g tell of the parameters, in units of what is left; e_g: chance and the law's error.
A law errs in proportion to what it does (discrepancy.py), and its error is a motion: in every direction in which
parameters move the windows of a gait it is a share of what drag (D_g) and of what the effects do there (E_g). Where two
parameters do nearly the same (to roll forward only tells nothing of how wheels roll backward), windows that are off by
little move a gait's values by much, which says nothing of other gaits; and of what one gait alone tells, the others say
how far the law is off. s and t are those of restricted maximum likelihood, as in the random effects of a meta-analysis
(DerSimonian and Laird, Controlled Clinical Trials 7, 177, 1986). An error that all gaits have in common is not seen by
comparing them; it is expected to be as large as what they do not share (the prediction interval of Higgins, Thompson
and Spiegelhalter, J. R. Stat. Soc. A 172, 137, 2009), and counts once more: what gaits do not share adds in squares,
what they have in common as it is.

What one explanation of an earlier campaign says of the change, another one does not, nor what stands beside it below
detection: the scatter of values, by what they do, is added, each explanation weighed by the inverse of what it left of
the earlier campaign, and by how likely this one is with it: its gaits are the independent numbers, of unknown scale, so
that is chi squared to the power -G / 2. Whether there is a change at all is another question: where all agree that
there is, and not how large it is, it is known to be there. Of that the tail of the mixture tells,

    p = 2 min(P, 1 - P),   P = sum_k w_k Phi(z_k),   z_k: standard deviations from the value that changes nothing

Legend: G gaits, P coordinates (eps first), K explanations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize
from scipy.special import ndtr, ndtri

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import CONFIDENCE, NORMAL
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.inference.fits.evidence import SILENT
from serpenoid.diagnose.inference.fits.finding import Named, interval
from serpenoid.diagnose.inference.fits.medium import Fit, linearised, predicted_bare

STARTS = ((-12.0, -12.0), (-12.0, -3.0), (-3.0, -12.0), (-3.0, -3.0))  # ln s^2, ln t^2: small or not
SMALLEST, LARGEST = -20.0, 6.0
LEAST_TAIL = 1e-300  # of a normal distribution: what is farther out is as far as this

Coordinate = tuple[str, int | None, int]  # an effect's name and place, and which of its coordinates


@dataclass(frozen=True)
class Doubted:
    """A value and its standard deviation, the law's error included; resting: what changes nothing.

    least, most: how many times as far from `resting` the value that does the same may be beside another explanation.
    sure: how many standard deviations it is known to be from `resting`, over all explanations; None: by its deviation.
    """

    value: float
    deviation: float
    resting: float = 0.0
    least: float = 1.0
    most: float = 1.0
    sure: float | None = None

    @property
    def away(self) -> float:
        """How many standard deviations it is known to be from `resting`."""
        return abs(_apart(self)) if self.sure is None else self.sure

    @property
    def ends(self) -> tuple[float, float]:
        """Of the 95 % interval, beside every explanation; without `resting` if all say that it is not that."""
        away, half = self.value - self.resting, NORMAL * self.deviation
        low, high = away - half, away + half
        if self.away > NORMAL and low * high < 0:
            near = (1 - NORMAL / self.away) * away
            low, high = (near, high) if away > 0 else (low, near)
        every = self.resting + np.outer([self.least, self.most], [low, high])
        return float(every.min()), float(every.max())

    def times(self, factor: float) -> Doubted:
        """With a value that is so many times as large, and does the same."""
        away = (self.value - self.resting) * factor
        return replace(self, value=self.resting + away, deviation=self.deviation * factor)


def doubted(explained: Sequence[tuple[Motion, Fit, float]], hold: bool = True) -> dict[Coordinate, Doubted]:
    """Of every coordinate, fitted beside one or more explanations of what the law misses, each with its weight.

    hold: what ended at a bound stays there.
    """
    found: dict[Coordinate, list[_Told]] = {}
    left = [fit.chi2 / float(fit.evidence.count.sum()) for _, fit, _ in explained]
    for (motion, fit, earlier), mine in zip(explained, left, strict=True):
        weight = earlier * (min(left) / mine) ** (len(set(motion.labels)) / 2)
        parameters = [(e, i, x) for e in fit.effects for i, x in enumerate(motion.unchanged(e))]
        values, deviations = of_gaits(motion, fit, hold)
        does = np.sqrt(np.diag(fit.evidence.matrix.sum(axis=0)))
        for at, (e, i, resting) in enumerate(parameters, 1):
            known = Doubted(float(values[at]), float(deviations[at]), resting)
            found.setdefault((e.name, e.place, i), []).append(_Told(known, weight, float(does[at])))
    return {name: _together(several) for name, several in found.items()}


class _Told(NamedTuple):
    """What one explanation says of a coordinate, its weight, and what a unit of it does there."""

    known: Doubted
    weight: float
    does: float

    def over(self, first: _Told) -> float:
        """What a unit does, over what it does beside the first explanation; 1 where one of them is held."""
        return self.does / first.does if self.does > 0 and first.does > 0 else 1.0


def _together(several: Sequence[_Told]) -> Doubted:
    """By what each value does, in the first one's numbers: motion tells no size of forces. Beside a law by which the
    floor resists a tenth as much, a tenth of a pull does the same, and says no less that there is one."""
    first, several = several[0], _likely(several)
    factors = [t.over(first) for t in several]
    alike = [t.known.times(x) for t, x in zip(several, factors, strict=True)]
    count, weights = len(several), np.array([t.weight for t in several])
    aways, variances = np.array([d.value - d.resting for d in alike]), np.array([d.deviation**2 for d in alike])
    mean = float(np.average(aways, weights=weights))
    between = float(np.average((aways - mean) ** 2, weights=weights)) * count / max(count - 1, 1)
    deviation = float(np.sqrt(np.average(variances, weights=weights) + between))
    least, most = min(1.0, 1 / max(factors)), max(1.0, 1 / min(factors))
    rest = first.known.resting
    return Doubted(rest + mean, deviation, rest, least, most, _surely(several))


def _surely(several: Sequence[_Told]) -> float | None:
    """How many standard deviations from one end of a normal distribution leave as much of it out as all explanations
    together do on the side of `resting` where there is less; one explanation has its own."""
    if len(several) == 1:
        return None
    apart, weights = np.array([_apart(t.known) for t in several]), [t.weight for t in several]
    below, above = (float(np.average(ndtr(x), weights=weights)) for x in (-apart, apart))
    return float(-ndtri(max(min(below, above), LEAST_TAIL)))


def _apart(known: Doubted) -> float:
    """Standard deviations of one explanation's value from `resting`, with its sign."""
    distance = known.value - known.resting
    if known.deviation > 0:
        return distance / known.deviation
    return float(np.copysign(np.inf, distance)) if distance else 0.0


def _likely(several: Sequence[_Told]) -> Sequence[_Told]:
    """Without the least likely."""
    ordered = sorted(several, key=lambda t: t.weight)
    summed = np.cumsum([t.weight for t in ordered])
    return ordered[int(np.searchsorted(summed, (1 - CONFIDENCE) * summed[-1], side="right")) :]


def yielding(named: Named, share: float, doubt: Mapping[Coordinate, Doubted]) -> Named:
    """A change with intervals that hold how far the body may give way to what it does on the floor's own law.

    share: what repeats share beyond what all changes do, over that.
    """
    effect, ends = named.effect, dict(named.intervals)
    for i, p in enumerate(effect.effect.parameters):
        known = doubt.get((effect.name, effect.place, i))
        if known is None or p.neutral is None:
            continue
        away = known.value - known.resting
        factors = np.exp(NORMAL * share * np.array([-1.0, 1.0]))
        wide = [float(np.clip(p.value(known.resting + away * x), p.lower, p.upper)) for x in factors]
        every = [*(np.inf if end is None else end for end in ends.get(p.name, ())), *wide]
        ends[p.name] = interval([min(every), max(every)])
    return replace(named, intervals=ends)


def of_gaits(motion: Motion, fit: Fit, hold: bool = True) -> tuple[Floats, Floats]:
    """Coordinates (P,) of one fit and their deviations, to first order about it; hold: see `doubted`."""
    own = len(fit.coordinates)
    inflated = max(1.0, fit.chi2 / float(fit.evidence.count.sum()))
    loose = linearised(motion, fit.model, fit.effects, near=fit.predictions, hold=False)[0] if not hold else None
    evidence = loose or fit.evidence
    matrix, vector = evidence.matrix[:, :own, :own], evidence.vector[:, :own]
    drag = _drag(motion, fit) if motion.ratio_held else matrix[:, 0, 0]
    done = np.stack([fit.coordinates[0] ** 2 * drag, _done(motion, fit)], axis=1)
    moved, spread = with_errors_of_gaits(matrix / inflated, vector / inflated, done / inflated)
    return fit.coordinates + moved, spread


def _drag(motion: Motion, fit: Fit) -> Floats:
    """Chi squared (G,) of what a unit of eps does in the windows of each gait, where it is held."""
    free = replace(motion, ratio_held=False)
    return linearised(free, fit.model, fit.effects, near=fit.predictions, hold=False)[0].matrix[:, 0, 0]


def with_errors_of_gaits(matrix: Floats, vector: Floats, done: Floats) -> tuple[Floats, Floats]:
    """How far all gaits together move the coordinates (P,) if each has an error of its own, and deviations (P,).

    matrix (G, P, P), vector (G, P): of chi squared, in units of what is left; done (G, 2): chi squared of what drag and
    of what the effects do, in which errors are in proportion.
    """
    told = np.diag(matrix.sum(axis=0))
    speaks = np.flatnonzero(told > SILENT)
    size = 1 / np.sqrt(told[speaks])
    a, b = matrix[:, speaks[:, None], speaks] * np.outer(size, size), vector[:, speaks] * size
    known, off = _directions(a, b)

    def deviance(log: Floats) -> float:
        variance = 1 + done @ np.exp(log)
        mean, covariance = _weighed(a, b, variance)
        explained = float((b / variance[:, None]).sum(axis=0) @ mean)
        return float((known * np.log(variance) + off / variance).sum() - np.linalg.slogdet(covariance)[1] - explained)

    bounds = [(SMALLEST, LARGEST)] * 2
    best = min((minimize(deviance, x, method="Nelder-Mead", bounds=bounds) for x in STARTS), key=lambda o: o.fun)
    error = done @ np.exp(best.x)
    mean, covariance = _weighed(a, b, 1 + error)
    pulled = np.einsum("ip,gpq,qi->gi", covariance, a, covariance) * (error / (1 + error) ** 2)[:, None]
    common = np.sqrt(np.maximum(pulled, 0.0)).sum(axis=0)
    moved, spread = np.zeros(len(told)), np.zeros(len(told))
    moved[speaks], spread[speaks] = mean * size, np.sqrt(np.diag(covariance) + common**2) * size
    return moved, spread


def _directions(matrix: Floats, vector: Floats) -> tuple[Floats, Floats]:
    """In how many directions each gait's windows tell of parameters, and chi squared of what is off there (G,)."""
    told, axes = np.linalg.eigh(matrix)
    pull = np.einsum("gpi,gp->gi", axes, vector)
    return (told > SILENT).sum(axis=1), (pull**2 / np.where(told > SILENT, told, np.inf)).sum(axis=1)


def _weighed(matrix: Floats, vector: Floats, variance: Floats) -> tuple[Floats, Floats]:
    """The mean of all gaits (P,) and its covariance; variance (G,): of each gait's errors, in units of what is left."""
    weight = (matrix / variance[:, None, None]).sum(axis=0)
    covariance = np.linalg.inv(weight + SILENT * np.eye(len(weight)))
    return covariance @ (vector / variance[:, None]).sum(axis=0), covariance


def _done(motion: Motion, fit: Fit) -> Floats:
    """Chi squared (G,) of what the effects do in the windows of each gait."""
    bare = predicted_bare(motion, fit) if fit.effects else fit.predictions
    done: dict[int, float] = {}
    parts = zip(motion.tracks, motion.labels, motion.white, fit.predictions, bare, strict=True)
    for track, label, white, p, q in parts:
        moved, known = p.displacement - q.displacement, track.usable & np.isfinite(p.displacement).all(axis=1)
        if known.any():
            squares = white.of(moved, known & np.isfinite(moved).all(axis=1)) ** 2
            done[label] = done.get(label, 0.0) + float(squares.sum())
    return np.array([done[label] for label in sorted(done)])
