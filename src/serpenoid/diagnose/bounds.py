"""Bounds in fits: what sits at one and is pushed outwards stays there, in fits and in scores on held-out gaits."""

from __future__ import annotations

from collections.abc import Sequence

from serpenoid.diagnose.evidence import Evidence
from serpenoid.effects.active import ActiveEffect
from serpenoid.model import Model

LEAST_EPS, MOST_EPS = 5e-3, 1.0  # where the medium states no bounds of its own
AT_BOUND = 1e-6  # of a typical value


def held_at_bounds(model: Model, effects: Sequence[ActiveEffect], evidence: Evidence) -> Evidence:
    """Evidence (eps, then the effects' coordinates) without what sits at a bound and is pushed outwards by the data."""
    push = evidence.vector.sum(axis=0)
    ends = [(model.medium.anisotropy_ratio, *model.medium.limits(LEAST_EPS, MOST_EPS), 1.0)]
    for e in effects:
        bounds = e.effect.coordinate_bounds(model.body, e.place)
        sizes = [max(abs(p.coordinate(p.typical)), 1e-6) for p in e.effect.parameters]
        ends += [(x, *pair, size) for x, pair, size in zip(e.coordinates, bounds, sizes, strict=False)]
    for column, (x, low, high, size) in enumerate(ends):
        least = AT_BOUND * size
        if (x <= low + least and push[column] < 0) or (x >= high - least and push[column] > 0):
            evidence = evidence.without(column)
    return evidence


def at_values(model: Model, effects: Sequence[ActiveEffect], drift: ActiveEffect | None) -> list[ActiveEffect]:
    """The effects in their order with the values they have in the model."""
    now = {(e.name, e.place): e for e in (*model.effects, *(() if drift is None else (drift,)))}
    return [now[e.name, e.place] for e in effects]
