"""What gaits of any family do: in the plane by their joint tables, in space (`[lift]`) by both of their waves.

Legend: B gaits, R rows, m joints, n parameters of a gait.
"""

from __future__ import annotations

from serpenoid.body import Floats
from serpenoid.gaits import GaitFamily
from serpenoid.gaits.lifted import LiftedFamily
from serpenoid.mechanics.tables import family_tables
from serpenoid.model import Model
from serpenoid.simulation.lifted import simulate_lifted, simulate_lifted_gaits
from serpenoid.simulation.rollout import Batch, simulate_batch, simulate_joint_angles
from serpenoid.trajectory import Trajectory


def simulate_gait(model: Model, family: GaitFamily, q: Floats) -> Trajectory:
    """The motion of gait q (n,)."""
    if isinstance(family, LiftedFamily):
        return simulate_lifted(model, family, q)
    return simulate_joint_angles(model, family_tables(model, family, q[None])[0], closed=family.closed)


def simulate_gaits(model: Model, family: GaitFamily, gaits: Floats, tables: Floats) -> Batch:
    """The motions of gaits (B, n), whose joint tables (B, R, m) are known."""
    if isinstance(family, LiftedFamily):
        return simulate_lifted_gaits(model, family, gaits)
    return simulate_batch(model, tables, family.closed)
