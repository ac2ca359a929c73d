"""Intervals that the parabola of chi squared carries beyond what a parameter can be: those of the profile instead.

    chi2(c) = min of chi2 over all other coordinates, c held;    chi2(end) = chi2(fit) + threshold

(Venzon and Moolgavkar, Applied Statistics 37, 87, 1988). The threshold is that by which a name is earned
(names.certain, left_open.known), so that no name has an interval which holds the value that changes nothing. Where chi
squared is a parabola, ends are the parabola's; a law that saturates is known to act where nobody can say how much: it
has one alone.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from serpenoid.diagnose.data.chance import NORMAL
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.inference.doubt.law_doubt import doubted
from serpenoid.diagnose.inference.doubt.left_open import Explained
from serpenoid.diagnose.inference.fits.evidence import SILENT
from serpenoid.diagnose.inference.fits.finding import Named, interval
from serpenoid.diagnose.inference.fits.medium import STEPS, Fit, coordinates_of, fit, linearised
from serpenoid.effects.active import ActiveEffect, joined
from serpenoid.effects.base import Parameter

NEAR = 0.01  # of the way to a bound or to the parabola's end: as exactly as an end is found


def in_its_range(motion: Motion, settled: Fit, named: Named, explained: Explained) -> Named:
    """A name of one parameter with the profile's interval, if its own reaches a bound or holds what changes nothing.

    explained: what is settled on beside every explanation of what the law misses; none where it is not wrong.
    """
    effect = next(e for e in settled.effects if e.key == named.effect.key)
    p, *more = effect.effect.parameters
    (rest,) = motion.unchanged(effect) if not more else (np.nan,)
    if more or p.neutral is None or _inside(p, p.value(rest), *named.intervals[p.name]):
        return named
    at = 1
    for e in settled.effects[: settled.effects.index(effect)]:
        at += len(e.effect.parameters)
    evidence, _ = linearised(motion, settled.model, settled.effects, near=settled.predictions, hold=False)
    index = range(len(settled.coordinates))
    spread = max(1.0, np.sqrt(settled.chi2 / settled.evidence.count.sum()))
    deviation = float(np.sqrt(evidence.covariance(index, spread)[at, at]))
    if explained:
        sure = doubted(explained, hold=False)[effect.name, effect.place, 0].away
        deviation = max(deviation, abs(effect.coordinates[0] - rest) / max(sure, SILENT))
    half = NORMAL * deviation
    threshold = half**2 / float(evidence.solve(index)[1][at, at])
    found = [p.value(x) for x in profile_ends(motion, settled, effect, threshold, half)]
    return replace(named, intervals={p.name: interval(found)})


def _inside(p: Parameter, rest: float, low: float | None, high: float | None) -> bool:
    """Whether an interval keeps away from bounds and from the value that changes nothing."""
    if low is None or high is None:
        return False
    return p.lower < low and high < p.upper and not low <= rest <= high


def profile_ends(
    motion: Motion, found: Fit, effect: ActiveEffect, threshold: float, half: float
) -> tuple[float, float]:
    """Lowest and highest coordinate of an effect of one parameter whose chi squared, everything else fitted again, is
    within `threshold` of the fit's; its bounds where nothing up to them is excluded. half: width of half a parabola."""
    (bounds,) = effect.effect.coordinate_bounds(found.model.body, effect.place)
    low, high = (_end(motion, found, effect, bound, threshold, half) for bound in bounds)
    return low, high


def _end(motion: Motion, found: Fit, effect: ActiveEffect, bound: float, threshold: float, half: float) -> float:
    value = effect.coordinates[0]

    def excess(x: float) -> float:
        more = _held_at(motion, found, effect, x) - found.chi2
        return float(np.sqrt(max(more, 0.0)) - np.sqrt(threshold))  # of a parabola a straight line

    if value == bound or excess(bound) <= 0:
        return bound
    return float(brentq(excess, bound, value, xtol=NEAR * min(abs(bound - value), half)))


def _held_at(motion: Motion, found: Fit, effect: ActiveEffect, x: float) -> float:
    """Chi squared with the effect held at a coordinate; the fit's own where not all windows have roots: there nothing
    is known."""
    held = replace(motion, held=joined(motion.held, [effect.with_coordinates([x])]))
    others = [e for e in found.effects if e.key != effect.key]
    start = coordinates_of(found.model, others)
    again = fit(held, found.model, others, start, STEPS, found.predictions)
    return again.chi2 if again.evidence.count.sum() >= found.evidence.count.sum() else found.chi2
