"""Certificate of a gait from elsewhere: a joint table, with or without the poses that somebody's own optimiser found.

The same checks as an optimum of this package gets, but those that need its NLP: step-by-step simulation reaches the
same poses, the joints stay within the problem's limits, and a finer mesh (the table joined by a periodic cubic spline)
tells the same displacement.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.optimise.certify import POSE_TOLERANCE
from serpenoid.optimise.program.limits import path_limits, violations
from serpenoid.problem import Problem
from serpenoid.shown import Shown
from serpenoid.simulation import simulate_joint_angles
from serpenoid.simulation.callers import problem_of
from serpenoid.simulation.given import finite, shaped
from serpenoid.simulation.mesh import FACTORS, MeshStudy, study_mesh
from serpenoid.status import Status
from serpenoid.trajectory import Trajectory
from serpenoid.wording import warned

WITHIN_LIMITS = 1e-9  # rad


@dataclass(frozen=True, repr=False, eq=False)
class OwnCertificate(Shown):
    """How a gait fared. resimulation_error: largest difference of poses (None: none were given); limit_excess: how far
    joint angles or their changes exceed the limits (negative: they do not) [rad]."""

    status: Status
    trajectory: Trajectory
    resimulation_error: float | None
    limit_excess: float
    mesh: MeshStudy

    def summary(self) -> str:
        """Status and displacement; of a gait beyond the problem's limits, by how much; what may be another unit."""
        over = f"joint angles or their changes exceed the problem's limits by {self.limit_excess:.1e} rad"
        said = over if self.status is Status.INFEASIBLE else self.status.value
        went = f"{said}, {self.trajectory.displacement:.6f} body lengths per cycle"
        return warned(went, self.trajectory.odd_units)


def certify_table(problem: Problem | str | Path, table: Floats, poses: Floats | None = None) -> OwnCertificate:
    """Check a closed joint table (T, m) [rad], and poses (T, 3) or (T + 1, 3) of its cycle [body lengths, rad].

    poses: of the body frame (weighted centroid, mean edge angle), from the origin, which may be left out.
    """
    problem = problem_of(problem)
    table = finite("table", shaped("table", table, (-1, problem.body.joint_count), least=3))
    trajectory = simulate_joint_angles(problem.model, table)
    error = None if poses is None else _apart(trajectory.poses, finite("poses", shaped("poses", poses, (-1, 3))))
    excess = float(violations(table, path_limits(problem)).max())
    meshes = [simulate_joint_angles(problem.model, finer(table, factor)) for factor in FACTORS]
    mesh = study_mesh(meshes, len(table))
    return OwnCertificate(_status(trajectory, error, excess, mesh), trajectory, error, excess, mesh)


def finer(table: Floats, factor: int) -> Floats:
    """The closed table with `factor` times as many rows, on a periodic cubic spline through its own."""
    rows = np.arange(len(table) + 1)
    spline = CubicSpline(rows, np.concatenate([table, table[:1]]), bc_type="periodic")
    return np.asarray(spline(np.arange(factor * len(table)) / factor))


def _status(trajectory: Trajectory, error: float | None, excess: float, mesh: MeshStudy) -> Status:
    if not trajectory.status.ok:
        return trajectory.status
    if error is not None and not error <= POSE_TOLERANCE:
        return Status.RESIMULATION_DISAGREES
    if excess > WITHIN_LIMITS:
        return Status.INFEASIBLE
    return Status.SOLVED if mesh.converged else Status.MESH_TOO_COARSE


def _apart(mine: Floats, theirs: Floats) -> float:
    if len(theirs) not in (len(mine), len(mine) - 1):
        raise InputError(f"`poses` must have {len(mine) - 1} rows, or {len(mine)} with the origin, got {len(theirs)}.")
    return float(np.abs(mine[-len(theirs) :] - theirs).max())
