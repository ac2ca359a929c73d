"""Intervals that stay where the number can be: a likelihood interval's ends are where it has lost 1.92, or its bound.

    chi2 lost(x) = (chi2(x) - chi2(best)) C / sd^2 = 1.96^2,   the other numbers fitted again at every x

with C the variance that noise alone would have, and sd the standard error that is stated: what is left and what is not
known of lengths, scales and curves widen both alike. Inside the bounds the ends are the usual best +- 1.96 sd to second
order, and then that is what is given.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtri, stdtrit

from serpenoid.body import Floats
from serpenoid.compare.likelihood import Segment, Solution, fit
from serpenoid.compare.parameters import bounds, changed, start_values
from serpenoid.model import Model

Z95 = float(ndtri(0.975))


def likelihood_intervals(model: Model, segments: tuple[Segment, ...], solution: Solution, sd: Floats) -> Floats:
    """95 % intervals (P, 2) that do not leave the numbers' bounds; `sd` (P,) with the noise scale in it."""
    lows, highs = bounds(solution.names, model)
    found = np.stack([solution.values - Z95 * sd, solution.values + Z95 * sd], axis=1)
    for i, (low, high) in enumerate(zip(lows, highs, strict=True)):
        if found[i, 0] < low:
            found[i, 0] = _end(model, segments, solution, i, float(low), sd[i])
        if found[i, 1] > high:
            found[i, 1] = _end(model, segments, solution, i, float(high), sd[i])
    return found


def within(names: tuple[str, ...], model: Model, values: Floats, half: Floats) -> Floats:
    """Intervals (P, 2) that far to either side of the values (P,), cut at the numbers' bounds."""
    return np.clip(np.stack([values - half, values + half], axis=1), *(ends[:, None] for ends in bounds(names, model)))


def _end(model: Model, segments: tuple[Segment, ...], solution: Solution, i: int, bound: float, sd: float) -> float:
    """Where the profile likelihood has lost 1.92 on the way to `bound`, or the bound."""
    lost = chi2_lost(model, segments, solution, i, sd)
    best = float(solution.values[i])
    if best == bound or lost(bound) <= Z95**2:
        return bound
    return float(brentq(lambda value: lost(value) - Z95**2, best, bound, xtol=1e-4 * abs(best - bound)))


def chi2_lost(
    model: Model, segments: tuple[Segment, ...], solution: Solution, i: int, sd: float
) -> Callable[[float], float]:
    """Chi2 above its minimum along number i, as a function of it; its standard error `sd` is 1 of that."""
    names = solution.names
    noise = changed(model, names, solution.values)  # values of chi2 are comparable only under one noise
    least = fit(noise, segments, (), np.empty(0)).chi2
    others = names[:i] + names[i + 1 :]
    share = solution.covariance[i, i] / sd**2

    def lost(value: float) -> float:
        fixed = changed(model, names[i : i + 1], np.array([value]))
        start = start_values(others, fixed) if others else np.empty(0)
        return float((fit(fixed, segments, others, start, noise).chi2 - least) * share)

    return lost


def mean_intervals(values: Floats, model: Model, names: tuple[str, ...]) -> Floats:
    """95 % Student intervals (P, 2) of the mean of (trials, P); by logits where plain ones leave a bound."""
    count, columns = len(values), values.shape[1]
    if count < 2:
        return np.full((columns, 2), np.nan)
    quantile, found = float(stdtrit(count - 1, 0.975)), np.empty((columns, 2))
    for i, (low, high) in enumerate(zip(*bounds(names, model), strict=True)):
        column = values[:, i]
        half = quantile * column.std(ddof=1) / np.sqrt(count)
        found[i] = column.mean() - half, column.mean() + half
        if found[i, 0] < low or found[i, 1] > high:
            share = np.clip((column - low) / (high - low), 1e-6, 1 - 1e-6)
            logit = np.log(share / (1 - share))
            half = quantile * logit.std(ddof=1) / np.sqrt(count)
            found[i] = low + (high - low) / (1 + np.exp(-(logit.mean() + np.array([-half, half]))))
    return found
