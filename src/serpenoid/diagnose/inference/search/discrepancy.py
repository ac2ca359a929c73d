"""What a law gets wrong is in proportion to what it does: an explanation's marginal likelihood, its errors included.

    m ~ N(0, v),   v = 1 + a^2 + b^2 E^2

m: mean residual of a setting's repeats in a window and direction, E: what the explanation's effects do there, both in
units of chance and doubt (white.py). a and b, the sizes of an error that everything shares and of one in proportion,
are what makes the campaign most likely, for each explanation anew: they shrink when a cause enters that takes their
place. A second effect that only mends the first one's law (a wheel beside the wheel) gains little; where the law is
exact, a = b = 0, and this is chi squared.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize
from scipy.special import stdtrit

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import CONFIDENCE
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.noise import residuals
from serpenoid.diagnose.data.noise.repeats import by_setting
from serpenoid.diagnose.data.noise.white import White
from serpenoid.diagnose.data.shapes.geometry import way
from serpenoid.diagnose.inference.fits.medium import Fit, candidates_of, predicted_bare
from serpenoid.diagnose.inference.fits.prices import gained_by_chance
from serpenoid.effects.active import ActiveEffect

STARTS = ((-16.0, -4.0), (-4.0, -16.0), (0.0, 0.0))  # ln a^2, ln b^2: one error alone, the other, both
SMALLEST, LARGEST = -20.0, 16.0


def outdone(motion: Motion, full: Fit, bases: Sequence[Fit]) -> list[bool]:
    """Which fits with an effect less are as likely as a fit: it gains no more than parameters and tries by chance."""
    if not bases:
        return []
    after = information_criterion(motion, full)
    return [information_criterion(motion, base) <= after for base in bases]


def information_criterion(motion: Motion, found: Fit) -> float:
    """The deviance and the price of parameters and tries: the least of several explanations is the best."""
    deviated, count = deviance(motion, found)
    return deviated + price(found, count)


def price(found: Fit, count: int) -> float:
    """Of a fit's parameters and tries beside so many means (prices.py)."""
    tries = gained_by_chance(len(candidates_of(found)) + len(found.effects))
    return len(found.coordinates) * float(np.log(max(count, 2))) + len(found.effects) * tries


def deviance(motion: Motion, found: Fit, exact: Sequence[ActiveEffect] = ()) -> tuple[float, int]:
    """-2 ln of an explanation's marginal likelihood, but for a constant of the campaign, and the number of means.

    exact: effects that have no error in proportion.
    """
    every, _ = surprises(motion, found, exact)
    return float(every.sum()), len(every)


def by_gait(motion: Motion, found: Fit) -> Floats:
    """The criterion of `information_criterion`, gait by gait and direction by direction (G, 3): the price is shared."""
    every, labels = surprises(motion, found)
    gaits = [every[labels == gait].reshape(-1, 3).sum(axis=0) for gait in sorted(set(motion.labels))]
    return np.array(gaits) + price(found, len(every)) / (3 * len(gaits))


def worse(gaits: Floats, best: Floats) -> bool:
    """Whether gaits and directions agree that what leaves so much in each (G, 3) is worse than the best explanation.

    In one gait what a law gets wrong along the body, across and in turning is nearly independent, and in its phases it
    is not (`benchmarks/independent_errors.py`).
    """
    apart = (gaits - best).ravel()
    if len(gaits) < 2:
        return False
    scatter = float(np.std(apart, ddof=1)) / np.sqrt(len(apart))
    return bool(apart.mean() > stdtrit(len(apart) - 1, CONFIDENCE) * scatter)


def surprises(motion: Motion, found: Fit, exact: Sequence[ActiveEffect] = ()) -> tuple[Floats, np.ndarray]:
    """-2 ln likelihood of each mean, direction by direction, and its gait (K,) each; exact: see `deviance`."""
    left, moved = residuals(motion.tracks, found.predictions), done(motion, found, exact)
    settings = by_setting(motion.tracks).values()
    parts = [_means(motion, left, moved, trials) for trials in settings]
    labels = [np.full(len(part[0]), motion.labels[trials[0]]) for part, trials in zip(parts, settings, strict=True)]
    mean, effect = (np.concatenate(x) for x in zip(*parts, strict=True))
    return _surprised(mean, effect), np.concatenate(labels)


def done(motion: Motion, found: Fit, besides: Sequence[ActiveEffect] = ()) -> list[Floats]:
    """What a fit's effects do in the windows (W, 3) of each track, besides some of them, and beside a reference what
    another eps does; 0 where the model has no path without them."""
    medium = found.model.medium
    was = medium.anisotropy_ratio if motion.ratio is None else motion.ratio
    there = len(found.effects) > len(besides) or was != medium.anisotropy_ratio
    without = replace(found, model=replace(found.model, medium=medium.with_ratio(was)))
    bare = predicted_bare(motion, without, besides) if there else found.predictions
    return [np.nan_to_num(p.displacement - q.displacement) for p, q in zip(found.predictions, bare, strict=True)]


def size_done(motion: Motion, found: Fit) -> float:
    """RMS [m] of what a fit's effects do to a window's displacement, turns as in `shared.discrepancy`."""
    moved = np.concatenate([m[t.usable] for t, m in zip(motion.tracks, done(motion, found), strict=True)])
    return way(motion.tracks[0].recording.body, np.mean(moved**2, axis=0))


def least_deviance(mean: Floats, effect: Floats) -> float:
    """The deviance of means (K,), by what effects do there (K,), both in units of chance and doubt."""
    return float(_surprised(mean, effect).sum())


def _surprised(mean: Floats, effect: Floats) -> Floats:
    """-2 ln likelihood of each mean (K,), with the errors that make all of them likeliest."""

    def each(log: Floats) -> Floats:
        v = 1 + np.exp(log[0]) + np.exp(log[1]) * effect**2
        return np.asarray(mean**2 / v + np.log(v))

    def whole(log: Floats) -> float:
        return float(each(log).sum())

    bounds = [(SMALLEST, LARGEST)] * 2
    best = min((minimize(whole, x, method="Nelder-Mead", bounds=bounds) for x in STARTS), key=lambda o: o.fun)
    return each(best.x)


def _means(motion: Motion, left: list[Floats], moved: list[Floats], trials: list[int]) -> tuple[Floats, Floats]:
    """Mean residuals of repeats where one is known and what effects do (K,) each, by chance and doubt."""
    first = motion.tracks[trials[0]]
    count, shape = min(len(left[i]) for i in trials), first.displacement.shape
    own, effect = (np.stack([x[i][:count] for i in trials]) for x in (left, moved))
    known = np.isfinite(own)
    times = np.zeros(shape)
    times[:count] = known.sum(axis=0)
    means = np.zeros((*shape, 2))
    means[:count] = np.where(known[..., None], np.stack([own, effect], axis=-1), 0.0).sum(axis=0)
    good = np.asarray(times.all(axis=1))
    means[good] /= times[good][..., None]
    white = White(first, motion.noise.chance(first), motion.noise.memory, np.maximum(times, 1)).of(means, good)
    return white[:, 0], white[:, 1]
