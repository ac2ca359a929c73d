"""Bounds in fits: what sits at one and is pushed outwards stays there, in fits and in scores on held-out gaits."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.diagnose.inference.fits.evidence import Evidence
from serpenoid.effects.active import ActiveEffect
from serpenoid.model import Model

LEAST_EPS, MOST_EPS = 5e-3, 1.0  # where the medium states no bounds of its own
AT_BOUND = 1e-6  # of a typical value


def held_at_bounds(model: Model, effects: Sequence[ActiveEffect], evidence: Evidence) -> Evidence:
    """Evidence (eps, then the effects' coordinates) without what sits at a bound and is pushed outwards by the data."""
    for column in _outwards(model, effects, evidence):
        evidence = evidence.without(column)
    return evidence


def gained_beyond(model: Model, effects: Sequence[ActiveEffect], evidence: Evidence) -> list[float]:
    """Chi squared that each effect would gain, to first order, if the data could push it beyond its bounds, what else
    is pushed beyond one being held; 0 of what is within. evidence: with nothing held."""
    held = _outwards(model, effects, evidence)
    free = [i for i in range(evidence.matrix.shape[1]) if i not in held]
    gains = {i: evidence.chi2(free) - evidence.chi2([*free, i]) for i in held}
    ends = np.cumsum([1, *(len(e.effect.parameters) for e in effects)])
    return [max(gains.get(i, 0.0) for i in range(a, b)) for a, b in zip(ends, ends[1:], strict=False)]


def _outwards(model: Model, effects: Sequence[ActiveEffect], evidence: Evidence) -> list[int]:
    """Columns that sit at a bound and are pushed outwards."""
    push = evidence.vector.sum(axis=0)
    low, high = model.medium.limits(LEAST_EPS, MOST_EPS)
    eps = model.medium.anisotropy_ratio
    sides = [(eps <= low, eps >= high), *(side for e in effects for side in _sides(model, e))]
    return [i for i, (below, above) in enumerate(sides) if (below and push[i] < 0) or (above and push[i] > 0)]


def ratio_at_bound(model: Model) -> bool:
    """Whether eps ended at a bound: a warning that the law is not the body's."""
    low, high = model.medium.limits(LEAST_EPS, MOST_EPS)
    return not low * (1 + AT_BOUND) < model.medium.anisotropy_ratio < high * (1 - AT_BOUND)


def _sides(model: Model, effect: ActiveEffect) -> list[tuple[bool, bool]]:
    """For each parameter, whether its coordinate is at its lower and at its upper bound."""
    bounds = effect.effect.coordinate_bounds(model.body, effect.place)
    sizes = [AT_BOUND * max(abs(p.coordinate(p.typical)), 1e-6) for p in effect.effect.parameters]
    trios = zip(effect.coordinates, bounds, sizes, strict=False)
    return [(x <= low + size, x >= high - size) for x, (low, high), size in trios]


def at_values(model: Model, effects: Sequence[ActiveEffect]) -> list[ActiveEffect]:
    """The effects in their order with the values they have in the model."""
    now = {e.key: e for e in model.effects}
    return [now[e.key] for e in effects]
