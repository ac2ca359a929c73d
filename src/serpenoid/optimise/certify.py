"""No optimum is believed before it passed three checks that IPOPT has no part in.

1. Re-simulation: the root-finder, step by step, reaches the same poses to 1e-8.
2. KKT residuals, unscaled, from the NLP's own derivatives: at most 1e-8.
3. Polishing: a derivative-free search over gait parameters and forward simulation gains less than 1e-6.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.optimise.interrupt import StopFlag
from serpenoid.optimise.motions import GaitBounds
from serpenoid.optimise.program.limits import TOLERANCE
from serpenoid.optimise.program.prepared import Carried
from serpenoid.optimise.solver import Answer, GaitSolver
from serpenoid.status import Status
from serpenoid.trajectory import Trajectory

POSE_TOLERANCE = 1e-8
KKT_TOLERANCE = 1e-8
GAIN_TOLERANCE = 1e-6
TRIALS = 32
DISTANCES = (1.0, 0.3, 0.1, 0.03, 0.01, 0.003)


@dataclass(frozen=True)
class Certificate:
    """How an answer fared: largest pose difference, polishing gain (None: not tried), the re-simulated trajectory."""

    status: Status
    trajectory: Trajectory
    table: Floats
    resimulation_error: float
    polishing_gain: float | None
    cost: float
    rest_is_as_good: bool = False


def certify(
    solver: GaitSolver,
    answer: Answer,
    c: float,
    polish: bool = True,
    gait_bounds: GaitBounds | None = None,
    flag: StopFlag | None = None,
) -> Certificate:
    """Check an answer of `solver` for dissipation coefficient c, found within `gait_bounds` (default the problem's).

    Polishing ends where the flag is raised, and is then as if it had not been tried.
    """
    table = solver.table(answer.q)
    trajectory = solver.simulate(answer.q)
    error = solver.pose_error(answer.outcome.point, trajectory)
    gain: float | None = None
    status = answer.outcome.status
    if status.ok and (not trajectory.status.ok or not error <= POSE_TOLERANCE):
        status = Status.RESIMULATION_DISAGREES
    if status.ok and not answer.outcome.residuals.largest <= KKT_TOLERANCE:
        status = Status.NOT_STATIONARY
    if status.ok and answer.clearance is not None and answer.clearance.proven < 0:
        status = Status.COLLIDES
    if status.ok and float(solver.excess(table).max()) > TOLERANCE:
        status = Status.EXCEEDS_LIMITS
    if status.ok and polish:
        gain = polishing_gain(solver, answer, c, gait_bounds or solver.gait_bounds(), flag)
        status = status if gain is None or gain < GAIN_TOLERANCE else Status.NOT_A_MINIMUM
    cost = solver.value(answer.q, table, trajectory, c)
    if trajectory.status.ok and np.isnan(cost):
        status = Status.NOT_A_NUMBER
    rest = status.ok and polish and rest_cost(solver, answer, c) < cost + GAIN_TOLERANCE
    return Certificate(status, trajectory, table, error, gain, cost, rest)


def rest_cost(solver: GaitSolver, answer: Answer, c: float) -> float:
    """The objective of a straight body that never moves; infinite where that misses what is asked."""
    straight = solver.family.scaled(answer.q, 0.0)[None]
    free, charged = (
        float(gait_costs(solver, straight, c, price, solver.gait_bounds(), answer.carried)[0]) for price in (0.0, 1.0)
    )
    return free if charged - free < KKT_TOLERANCE else np.inf


def gait_costs(
    solver: GaitSolver, gaits: Floats, c: float, penalty: float, gait_bounds: GaitBounds, carried: Carried | None = None
) -> Floats:
    """The objective of gaits (B, n) by forward simulation, plus `penalty` times every violation."""
    lower, upper = gait_bounds
    inside = np.clip(gaits, np.maximum(lower, -1e6), upper)
    tables = solver.tables(inside)
    found = solver.costs(tables, inside, c)
    outside = found.outside + np.maximum(lower - gaits, 0).sum(1) + np.maximum(gaits - upper, 0).sum(1)
    if found.batch is not None:
        carried = carried or Carried()
        outside = outside + solver.obstacles.too_near(carried.watch, tables, found.batch, carried.margin)
    if solver.limits.any:
        outside += np.maximum(solver.excess(tables).max(axis=(-2, -1)) - TOLERANCE, 0)
    return np.where(found.sound, found.value + penalty * outside, np.inf)


def missed(solver: GaitSolver, q: Floats, c: float) -> float:
    """By how much a gait, simulated, misses limits and demands together; infinite where it cannot be simulated."""
    gaits = np.clip(q, *solver.gait_bounds())[None]
    free, charged = (float(gait_costs(solver, gaits, c, price, solver.gait_bounds())[0]) for price in (0.0, 1.0))
    return charged - free if np.isfinite(charged) else np.inf


def polishing_gain(
    solver: GaitSolver, answer: Answer, c: float, gait_bounds: GaitBounds, flag: StopFlag | None = None
) -> float | None:
    """How much a derivative-free search around the answer lowers the cost (exact penalty for the constraints); None
    where the flag is raised meanwhile.

    Random trial gaits at shrinking distances, the best so far in the middle; each distance is one compiled batch.
    """
    penalty = 10 * (1 + float(np.max(np.abs(answer.outcome.point.lam_g))))
    lower, upper = gait_bounds
    width = np.where(upper > lower, solver.family.widths, 0.0)
    rng = np.random.default_rng(0)
    best, first = answer.q, float(gait_costs(solver, answer.q[None], c, penalty, gait_bounds, answer.carried)[0])
    lowest = first
    for distance in DISTANCES:
        if flag:
            return None
        trials = best + distance * width * rng.standard_normal((TRIALS, best.size))
        trials = np.clip(trials, lower, upper)
        costs = gait_costs(solver, trials, c, penalty, gait_bounds, answer.carried)
        if costs.min() < lowest:
            lowest, best = float(costs.min()), trials[costs.argmin()]
    return first - lowest
