"""Values that the stage of motion finds, and how well they are known: of what is named, and of eps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.special import stdtrit

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import CONFIDENCE, NORMAL, SYSTEMATIC
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.inference.doubt.differing import Differing
from serpenoid.diagnose.inference.doubt.law_doubt import Coordinate, Doubted, of_gaits
from serpenoid.diagnose.inference.fits.bounds import LEAST_EPS, MOST_EPS, ratio_at_bound
from serpenoid.diagnose.inference.fits.finding import VISIBLE, Named, Stage, interval
from serpenoid.diagnose.inference.fits.medium import Fit, fit_guided, linearised
from serpenoid.diagnose.inference.search.names import seen
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.effects.active import ActiveEffect, of_key

RELATIVE = 3e-3  # what smoothing the shapes leaves


def named_of(
    found: Selection, base: Fit, effect: ActiveEffect, doubt: Mapping[Coordinate, Doubted] | None = None
) -> Named:
    """Values and intervals from the fit with all that is there, strength from what the path loses without the effect
    (`base`); doubt: where the law is known to be wrong, what that leaves open."""
    settled = found.settled
    at = 1
    for fitted in settled.effects:
        if fitted.key == effect.key:
            break
        at += len(fitted.effect.parameters)
    ends, bound, usual = {}, [], deviations(found.motion, settled)
    unchanged = found.motion.unchanged(fitted)
    coarse = float(np.sqrt(np.mean([t.coarse**2 for t in found.motion.tracks])))
    for i, p in enumerate(fitted.effect.parameters):
        x, value = fitted.coordinates[i], fitted.parameters[p.name]
        held = value <= p.lower + 1e-6 * abs(p.typical) or value >= p.upper - 1e-6 * abs(p.typical)
        if held:
            bound.append(p.name)
        sd = float((deviations(found.motion, settled, hold=False) if held else usual)[at + i])
        half = NORMAL * float(np.hypot(sd, coarse * abs(x - unchanged[i]))) + RELATIVE * abs(x)
        low, high = x - half, x + half
        doubtful = (doubt or {}).get((fitted.name, fitted.place, i))
        if doubtful is not None:
            low, high = min(low, doubtful.ends[0]), max(high, doubtful.ends[1])
        ends[p.name] = interval([_clipped(p.value(end), p.lower, p.upper) for end in (low, high)])
    strength = seen(found.motion, found.best, base, effect, VISIBLE * found.noise_level_m) / found.noise_level_m
    known = of_key(found.motion.held, effect.key)
    return Named(fitted, ends, strength, tuple(bound), before={} if known is None else known.parameters)


def beside_known(named: Named, doubt: Floats) -> Named:
    """What was known of the same effect is a part of its value: with intervals that hold how far that may be off, by
    how much less and more (P, 2) its coordinates may have been."""
    if not doubt.any():
        return named
    ends = dict(named.intervals)
    for p, (less, more) in zip(named.effect.effect.parameters, doubt, strict=True):
        if p.name in ends:
            low, high = sorted(p.coordinate(np.inf if end is None else end) for end in ends[p.name])
            ends[p.name] = interval([_clipped(p.value(end), p.lower, p.upper) for end in (low + less, high + more)])
    return replace(named, intervals=ends)


def deviations(motion: Motion, fit: Fit, hold: bool = True) -> Floats:
    """Standard deviations of eps and all coordinates (P,), from the curvature.

    hold: what ended at a bound stays there, as in the fit; else how far it may be from there.
    """
    evidence = fit.evidence if hold else linearised(motion, fit.model, fit.effects, hold=False)[0]
    spread = SYSTEMATIC * max(1.0, np.sqrt(fit.chi2 / fit.evidence.count.sum()))
    return np.sqrt(np.diag(evidence.covariance(range(len(fit.coordinates)), spread)))


def ratio_interval(found: Selection, stage: Stage) -> tuple[float, float]:
    """95 % interval of eps with what is there; where something is left, over what gaits disagree about."""
    fits = fits_of_ratio(found, stage)
    motion = found.motion
    if motion.ratio_held:
        motion = replace(motion, ratio_held=False)
        fits = [fit_guided(motion, f, 0) for f in fits]
    every = [ratio_ends(motion, f) for f in fits] + [stage.ratio] * (stage.ratio is not None)
    wrong = not stage.settled and not stage.unlike
    every += [ends_by_gaits(motion, f) for f in fits] if wrong or stage.discrepancy_m > 0 else []
    low, high = zip(*every, strict=True)
    return min(low), max(high)


def fits_of_ratio(found: Selection, stage: Stage) -> list[Fit]:
    """By which eps is told. Names that may be stand-ins may take a part of what resists, or give it: then eps is known
    no better than with and without them."""
    unsure = not stage.unlike and any(n.stand_in for n in stage.named)
    return [found.settled, found.null] if unsure else [found.settled]


def ends_by_gaits(motion: Motion, found: Fit) -> tuple[float, float]:
    """Where every gait has an error of its own in what drag does (law_doubt.py), whose size G gaits tell as a variance
    with G - 1 degrees of freedom: Student's t. One gait alone tells nothing of it."""
    limits = found.model.medium.limits(LEAST_EPS, MOST_EPS)
    gaits = len(set(motion.labels))
    if gaits < 2:
        return limits
    moved, spread = of_gaits(motion, found, hold=not ratio_at_bound(found.model))
    half = float(stdtrit(gaits - 1, (1 + CONFIDENCE) / 2) * spread[0])
    return _clipped(moved[0] - half, *limits), _clipped(moved[0] + half, *limits)


def ratio_beside(parts: Differing, settled: Fit) -> tuple[float, float]:
    """The same beside parts that differ."""
    half, limits = NORMAL * parts.ratio.deviation, settled.model.medium.limits(LEAST_EPS, MOST_EPS)
    return _clipped(parts.ratio.value - half, *limits), _clipped(parts.ratio.value + half, *limits)


def ratio_ends(motion: Motion, found: Fit, reach: float = NORMAL) -> tuple[float, float]:
    """From the curvature and what gaits disagree about, so many standard deviations either way, within the bounds of
    eps."""
    eps, low_high = found.model.medium.anisotropy_ratio, found.model.medium.limits(LEAST_EPS, MOST_EPS)
    half = reach * float(deviations(motion, found, hold=not ratio_at_bound(found.model))[0]) + RELATIVE * eps
    return _clipped(eps - half, *low_high), _clipped(eps + half, *low_high)


def _clipped(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)
