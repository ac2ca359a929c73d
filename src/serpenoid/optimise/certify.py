"""No optimum is believed before it passed three checks that IPOPT has no part in.

1. Re-simulation: the root-finder, step by step, reaches the same poses to 1e-8.
2. KKT residuals, unscaled, from the NLP's own derivatives: at most 1e-8.
3. Polishing: Nelder-Mead over gait parameters and forward simulation (no derivatives, no NLP) gains less than 1e-6.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from serpenoid.body import Floats
from serpenoid.mechanics.tables import joint_table, joint_tables
from serpenoid.optimise.limits import worst_violation
from serpenoid.optimise.solver import Answer, GaitBounds, GaitSolver
from serpenoid.simulation import simulate_batch, simulate_joint_angles
from serpenoid.status import Status
from serpenoid.trajectory import Trajectory

POSE_TOLERANCE = 1e-8
KKT_TOLERANCE = 1e-8
GAIN_TOLERANCE = 1e-6
EVALUATIONS = 400
SIMPLEX = np.array([0.02, 0.1, 0.1, 0.02, 0.1, 0.02])  # first simplex: a few per cent of each parameter's range
FEASIBLE = 1e-9


@dataclass(frozen=True)
class Certificate:
    """How an answer fared: largest pose difference, polishing gain (None: not tried), the re-simulated trajectory."""

    status: Status
    trajectory: Trajectory
    table: Floats
    resimulation_error: float
    polishing_gain: float | None


def certify(
    solver: GaitSolver, answer: Answer, c: float, polish: bool = True, gait_bounds: GaitBounds | None = None
) -> Certificate:
    """Check an answer of `solver` for dissipation coefficient c, found within `gait_bounds` (default the problem's)."""
    table = joint_table(solver.model, answer.q, solver.steps)
    trajectory = simulate_joint_angles(solver.model, table)
    poses = answer.outcome.point.x[:-6].reshape(-1, 3)
    error = float(np.max(np.abs(trajectory.poses[1:] - poses)))
    gain: float | None = None
    status = answer.outcome.status
    if status.ok and (not trajectory.status.ok or not error <= POSE_TOLERANCE):
        status = Status.RESIMULATION_DISAGREES
    if status.ok and not answer.outcome.residuals.largest <= KKT_TOLERANCE:
        status = Status.NOT_STATIONARY
    if status.ok and polish and solver.customise is None:
        gain = polishing_gain(solver, answer, c, gait_bounds or solver.gait_bounds())
        status = status if gain < GAIN_TOLERANCE else Status.NOT_A_MINIMUM
    return Certificate(status, trajectory, table, error, gain)


def gait_costs(solver: GaitSolver, gaits: Floats, c: float, penalty: float, gait_bounds: GaitBounds) -> Floats:
    """-Delta + c * dissipation of gaits (B, 6) by forward simulation, plus `penalty` times every violation."""
    lower, upper = gait_bounds
    tables = joint_tables(solver.model, np.clip(gaits, np.maximum(lower, -1e6), upper), solver.steps)
    batch = simulate_batch(solver.model, tables)
    cost = -batch.displacement + c * batch.dissipation
    outside = np.maximum(lower - gaits, 0).sum(1) + np.maximum(gaits - upper, 0).sum(1)
    outside += np.maximum(worst_violation(tables, solver.limits) - FEASIBLE, 0)
    target = solver.heading_target()
    if target is not None:
        outside += np.abs(batch.poses[:, -1, 2] - target)
    return np.where(batch.sound, cost + penalty * outside, np.inf)


def polishing_gain(solver: GaitSolver, answer: Answer, c: float, gait_bounds: GaitBounds) -> float:
    """How much a derivative-free search beside the answer lowers the cost (exact penalty for the constraints)."""
    penalty = 10 * (1 + float(np.max(np.abs(answer.outcome.point.lam_g))))

    def cost(q: Floats) -> float:
        return float(gait_costs(solver, q[None], c, penalty, gait_bounds)[0])

    lower, upper = gait_bounds
    width = np.where(upper > lower, SIMPLEX, 0.0)
    simplex = np.vstack([answer.q, answer.q + np.diag(width)])[[True, *(width > 0)]]
    moving = width > 0
    base = answer.q.copy()

    def reduced(z: Floats) -> float:
        q = base.copy()
        q[moving] = z
        return cost(q)

    options = {"initial_simplex": simplex[:, moving], "maxfev": EVALUATIONS, "xatol": 1e-9, "fatol": 1e-12}
    found = minimize(reduced, base[moving], method="Nelder-Mead", options=options)
    return max(0.0, cost(base) - float(found.fun))
