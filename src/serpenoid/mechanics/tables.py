"""Joint tables of elliptical gaits, by numbers.

Legend: B gaits, T steps, m joints.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.mechanics import functions
from serpenoid.mechanics.compile import compiled
from serpenoid.mechanics.evaluate import evaluate
from serpenoid.model import Model, Structure


def joint_table(model: Model, q: Floats, steps: int) -> Floats:
    """Joint table of gait parameters q (6,), shape (T, m) [rad]."""
    return joint_tables(model, np.asarray(q)[None], steps)[0]


def joint_tables(model: Model, gaits: Floats, steps: int) -> Floats:
    """Joint tables of gait parameters (B, 6), shape (B, T, m) [rad]."""
    count = gaits.shape[0]
    phases = np.tile(np.arange(steps) / steps, count)
    rows = np.repeat(np.asarray(gaits, float), steps, axis=0)
    (angles,) = evaluate(_mapped(model.structure, count * steps), rows, phases, model.parameters)
    return np.ascontiguousarray(angles.T).reshape(count, steps, -1)


@lru_cache(maxsize=32)
def _mapped(structure: Structure, rows: int) -> ca.Function:
    return _compiled(structure).map("table", "serial", rows, [2], [])


@lru_cache(maxsize=32)
def _compiled(structure: Structure) -> ca.Function:
    return compiled([functions.gait_joint_angles(structure)])[0]
