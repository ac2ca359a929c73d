"""What the servos' readings say for an actuation effect: how they depend on its numbers, and how much the best of all
candidates would take away by chance.

Legend: R log rows of all trials, m joints, P parameters of an effect.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.recordings.recording import held_out_labels
from serpenoid.diagnose.inference.fits.evidence import Evidence
from serpenoid.diagnose.inference.search.null import Scored, largest_by_chance
from serpenoid.diagnose.stages.actuation.actuation_candidates import places_of, shown
from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import ActuationEffect, Parameter
from serpenoid.files.store import remembered


@remembered
def needed(data: Plays, chosen: Sequence[ActiveEffect]) -> float:
    """Chi squared that an effect must take away: the best of all candidates takes as much of what is left by chance.

    A candidate's column is what its law, where its fit begins, changes of what is played.
    """
    here = data.realised(chosen)
    left = data.left(here)
    own = [slope for _, missed in slopes_of_each(data, chosen, chosen, here) for slope in missed]
    kinds = [k for k in shown(data) if k.place is not None or all(e.name != k.name for e in chosen)]
    begun = [(kind, start) for kind in kinds for start in kind.starts(data.readings, data.quickest)]
    played = data.realised_each([_beside(data, chosen, kind, start) for kind, start in begun])
    changed = [data.slope(left, p, 1.0) / data.noise for p in played]
    everywhere = [c for (kind, _), c in zip(begun, changed, strict=True) if kind.place is None]
    at_joint = [c for (kind, _), c in zip(begun, changed, strict=True) if kind.place is not None]
    return largest_by_chance([_scored(data, left / data.noise, own, everywhere, at_joint)])


def _beside(data: Plays, chosen: Sequence[ActiveEffect], kind: ActuationEffect, start: Floats) -> list[ActiveEffect]:
    """An effect everywhere beside the chosen."""
    places, start = places_of(kind, data), np.atleast_2d(start)
    resting, typical = (np.array([[x] for x in f]) for f in _rests(kind.parameters))
    moderate = np.where(start == resting, typical, start)
    tried = [ActiveEffect.neutral(kind.name, p).with_coordinates(moderate[:, (p or 1) - 1]) for p in places]
    return [*(e for e in chosen if e.key not in {t.key for t in tried}), *tried]


def _rests(parameters: Sequence[Parameter]) -> tuple[list[float], list[float]]:
    """Resting and typical coordinates."""
    return [p.resting for p in parameters], [p.coordinate(p.typical) for p in parameters]


def _scored(
    data: Plays, left: Floats, own: Sequence[Floats], everywhere: Sequence[Floats], at_joint: Sequence[Floats]
) -> Scored:
    """Sums joint by joint: columns of the chosen, then one of each effect everywhere, then of each at each joint."""
    labels = np.array(held_out_labels(data.recordings))[data.trials]
    shared, joints = len(own) + len(everywhere), left.shape[1]
    size, gaits = shared + len(at_joint) * joints, len(np.unique(labels))
    matrix, vector = np.zeros((gaits, size, size)), np.zeros((gaits, size))
    constant, count = np.zeros(gaits), np.array([float(data.read[labels == k].sum()) for k in np.unique(labels)])
    for j in range(joints):
        columns = np.stack([c[:, j] for c in (*own, *everywhere, *at_joint)], axis=1)
        e = Evidence.of(left[:, j], columns, labels)
        index = [*range(shared), *(shared + i * joints + j for i in range(len(at_joint)))]
        matrix[np.ix_(range(gaits), index, index)] += e.matrix
        vector[np.ix_(range(gaits), index)] += e.vector
        constant = constant + e.constant
    return Scored(Evidence(matrix, vector, constant, count), len(own), tuple((i,) for i in range(len(own), size)))


def slopes_of(data: Plays, chosen: Sequence[ActiveEffect], effect: ActiveEffect, here: Floats) -> tuple[Floats, Floats]:
    """Of what is played where it is read, and of what is left at the best shifts in time, by one chosen effect's
    coordinates, in units of noise (P, R, m); here: what all of them play."""
    return slopes_of_each(data, chosen, [effect], here)[0]


def slopes_of_each(
    data: Plays, chosen: Sequence[ActiveEffect], some: Sequence[ActiveEffect], here: Floats
) -> list[tuple[Floats, Floats]]:
    """The same of each of some."""
    left, steps = data.left(here), [_steps(e, data.held) for e in some]
    sets = [
        [*(other for other in chosen if other.key != e.key), e.moved(k, step)]
        for e, every in zip(some, steps, strict=True)
        for k, step in enumerate(every)
    ]
    moved, found = iter(zip(sets, data.realised_each(sets), strict=True)), []
    for e, every in zip(some, steps, strict=True):
        late = data.met(chosen)[1] if isinstance(e.effect, ActuationEffect) and e.effect.dead_time else None
        played, missed = [], []
        for step, (effects, angles) in zip(every, islice(moved, len(every)), strict=True):
            # a start that is open would follow it
            bare = angles if late is None else data.begun_at([effects], late)[0]
            played.append(np.where(data.read, bare - here, 0.0) / step / data.noise)
            missed.append(data.slope(left, angles, step) / data.noise)
        found.append((np.stack(played), np.stack(missed)))
    return found


def _steps(effect: ActiveEffect, held: bool) -> list[float]:
    """By how much each coordinate is moved."""
    pairs = zip(effect.effect.parameters, effect.coordinates, strict=False)
    return [(p.across if held else 0.0) or 1e-4 * max(abs(x), 1e-3 * abs(p.coordinate(p.typical))) for p, x in pairs]
