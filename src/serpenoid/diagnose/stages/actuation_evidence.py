"""What the servos' readings say for an actuation effect: how they depend on its numbers, and how much the best of all
candidates would take away by chance.

Legend: R log rows of all trials, m joints, P parameters of an effect.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.recording import held_out_labels
from serpenoid.diagnose.inference.evidence import Evidence
from serpenoid.diagnose.inference.null import Scored, largest_by_chance
from serpenoid.diagnose.stages.actuation_candidates import places_of, shown
from serpenoid.diagnose.stages.plays import Plays
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
    own = [slope for e in chosen for slope in slopes_of(data, chosen, e, here)[1]]
    everywhere: list[Floats] = []
    at_joint: list[Floats] = []
    for kind in shown(data):
        if kind.place is None and any(e.name == kind.name for e in chosen):
            continue
        columns = [_changed(data, chosen, kind, start, left) for start in kind.starts(data.readings, data.quickest)]
        (everywhere if kind.place is None else at_joint).extend(columns)
    return largest_by_chance([_scored(data, left / data.noise, own, everywhere, at_joint)])


def _changed(data: Plays, chosen: Sequence[ActiveEffect], kind: ActuationEffect, start: Floats, left: Floats) -> Floats:
    """What an effect everywhere changes of what is left (R, m), in units of noise."""
    places, start = places_of(kind, data), np.atleast_2d(start)
    resting, typical = (np.array([[x] for x in f]) for f in _rests(kind.parameters))
    moderate = np.where(start == resting, typical, start)
    tried = [ActiveEffect.neutral(kind.name, p).with_coordinates(moderate[:, (p or 1) - 1]) for p in places]
    kept = [e for e in chosen if e.key not in {t.key for t in tried}]
    return data.slope(left, data.realised([*kept, *tried]), 1.0) / data.noise


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
    others = [e for e in chosen if e.key != effect.key]
    late = data.met(chosen)[1] if isinstance(effect.effect, ActuationEffect) and effect.effect.dead_time else None
    left, played, missed = data.left(here), [], []
    for k, (p, x) in enumerate(zip(effect.effect.parameters, effect.coordinates, strict=False)):
        little = 1e-4 * max(abs(x), 1e-3 * abs(p.coordinate(p.typical)))
        step = (p.across if data.held else 0.0) or little
        effects = [*others, effect.moved(k, step)]
        moved = data.realised(effects)
        bare = moved if late is None else data.begun_at(effects, late)  # a start that is open would follow it
        played.append(np.where(data.read, bare - here, 0.0) / step / data.noise)
        missed.append(data.slope(left, moved, step) / data.noise)
    return np.stack(played), np.stack(missed)
