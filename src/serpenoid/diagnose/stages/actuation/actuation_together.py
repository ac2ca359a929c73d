"""All actuation effects fitted at once, by Levenberg-Marquardt: where several share all joints, or all joints share
when a trial began.

Legend: R log rows of all trials, m joints.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.inference.fits.medium import CONVERGED
from serpenoid.diagnose.stages.actuation.actuation_by_joint import in_reach, inside
from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.effects.active import ActiveEffect
from serpenoid.files.store import remembered

HOPELESS = 1e6  # damping: no step gains anything


@remembered
def fit_together(data: Plays, chosen: Sequence[ActiveEffect], steps: float = np.inf) -> tuple[ActiveEffect, ...]:
    """Levenberg-Marquardt in the parameters of all effects at once, so many steps at most: where nothing says when
    trials began, that depends on what every joint does, and what every other one is fitted to depends on it."""
    parameters = [p for e in chosen for p in e.effect.parameters]
    owner = [e for e in chosen for _ in e.effect.parameters]
    ends = np.cumsum([len(e.effect.parameters) for e in chosen])[:-1]
    small = np.array([p.small(data.held) for p in parameters])
    sets = _side_by_side(owner)

    def at(x: Floats) -> list[ActiveEffect]:
        return [e.with_coordinates(v) for e, v in zip(chosen, np.split(x, ends), strict=True)]

    values, damping = np.array([x for e in chosen for x in e.coordinates[:-1]]), 1e-4
    positive = np.array([p.lower >= 0 for p in parameters]) & (values > 0)
    here, late = data.met(at(values))
    left, taken = data.left(here), 0
    while True:
        cost = float(data.sizes(left).sum())
        moved = data.begun_at([at(values + np.where(sets == k, small, 0.0)) for k in range(sets.max() + 1)], late)
        change = [_at_place(moved[k] - here, e) for k, e in zip(sets, owner, strict=True)]
        slopes = np.stack([data.slope(left, here + c, x) for c, x in zip(change, small, strict=True)]) / data.noise
        # what is left is at the best moves of clocks, so that only the bare change turns it into the gradient
        pull = np.array([(left * c / data.noise**2).sum() for c in change]) / small
        matrix = np.einsum("irm,jrm->ij", slopes, slopes)
        size = np.sqrt(np.maximum(np.diag(matrix), 1e-12))
        gained = -np.inf
        while gained < 0 and damping < HOPELESS:
            step = np.linalg.solve(matrix / np.outer(size, size) + damping * np.eye(len(size)), pull / size) / size
            step = np.where(positive, in_reach(step, values), step)
            trial = np.array([inside(p, v) for p, v in zip(parameters, values + step, strict=True)])
            played, begun = data.met(at(trial))
            missed = data.left(played)
            gained = cost - float(data.sizes(missed).sum())
            damping *= 0.1 if gained >= 0 else 30.0
        if gained < 0:
            return tuple(at(values))
        values, here, late, left, damping = trial, played, begun, missed, max(damping, 1e-9)
        taken += 1
        if gained < CONVERGED * max(1.0, cost / float(data.often.sum())) or taken >= steps:
            return tuple(at(values))


def _side_by_side(chosen: Sequence[ActiveEffect]) -> np.ndarray:
    """In which set each parameter, by its effect, can be moved at once with the others there: no two of one are at one
    joint."""
    sets: list[set[int | None]] = []
    found = []
    for e in chosen:
        room = (k for k, places in enumerate(sets) if e.place is not None and not places & {None, e.place})
        found.append(next(room, len(sets)))
        if found[-1] == len(sets):
            sets.append(set())
        sets[found[-1]].add(e.place)
    return np.array(found)


def _at_place(change: Floats, effect: ActiveEffect) -> Floats:
    """Of what is read (R, m), at the effect's joint alone; all of it of an effect at all joints."""
    if effect.place is None:
        return change
    own = np.zeros_like(change)
    own[:, effect.place - 1] = change[:, effect.place - 1]
    return own
