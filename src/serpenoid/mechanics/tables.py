"""Joint tables of gaits, by numbers.

Legend: B gaits, R rows, m joints, n parameters of a gait.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.gaits import EllipseGait, GaitFamily
from serpenoid.mechanics import functions
from serpenoid.mechanics.columns import OverColumns, over_columns
from serpenoid.model import Model, Structure


def joint_table(model: Model, q: Floats, steps: int) -> Floats:
    """Joint table of ellipse parameters q (6,), shape (T, m) [rad]."""
    return joint_tables(model, np.asarray(q)[None], steps)[0]


def joint_tables(model: Model, gaits: Floats, steps: int) -> Floats:
    """Joint tables of ellipse parameters (B, 6), shape (B, T, m) [rad]."""
    return family_tables(model, EllipseGait().of(model.body.joint_count, steps), gaits)


def family_tables(model: Model, family: GaitFamily, gaits: Floats) -> Floats:
    """Joint tables of any family's parameters (B, n), shape (B, R, m) [rad]."""
    gaits, count = np.asarray(gaits, float), len(gaits)
    if family.free:
        return gaits.reshape(count, family.rows, family.joints)
    rows = gaits[:, family.indices].reshape(count * family.rows, -1)
    columns = np.hstack([rows, np.tile(family.data, (count, 1))])
    (angles,) = _over_rows(model.structure, family)(columns, model.parameters)
    return np.ascontiguousarray(angles.T).reshape(count, family.rows, -1)


@lru_cache(maxsize=32)
def _over_rows(structure: Structure, family: GaitFamily) -> OverColumns:
    """((parameters of a row, its data) (C, k + d), model parameters) -> joint angles (m, C)."""
    angles = functions.gait_joint_angles(structure, family)
    sizes = [angles.size1_in(i) for i in range(3)]
    column, parameters = ca.SX.sym("column", sum(sizes[:2])), ca.SX.sym("parameters", sizes[2])
    value = angles(column[: sizes[0]], column[sizes[0] :], parameters)
    return over_columns(ca.Function("table", [column, parameters], [value], functions.CSE))
