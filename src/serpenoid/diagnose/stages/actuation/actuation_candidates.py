"""Which actuation effects the servos' readings can show, and at which joints.

Legend: R log rows of all trials, m joints.
"""

from __future__ import annotations

import numpy as np

from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.effects.base import ActuationEffect, Effect
from serpenoid.effects.catalogue import actuation_effects


def shown(data: Plays) -> list[ActuationEffect]:
    """Actuation effects that readings show, but for those left out. A dead time is a late start where nothing says when
    trials began."""
    said = all(data.said(r) for r in data.recordings)
    every = (k for k in actuation_effects() if k.shown and k.name not in data.without)
    return [k for k in every if said or not k.dead_time]


def places_of(kind: Effect, data: Plays) -> list[int | None]:
    """Every joint that is read, or none."""
    return [None] if kind.place is None else [int(j) + 1 for j in np.flatnonzero(data.read.any(axis=0))]
