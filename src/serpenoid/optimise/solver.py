"""One gait optimisation: NLP, start, limits, IPOPT, from a start gait to a primal-dual answer. No certificate yet.

Legend: T steps, m joints, K path rows, q gait parameters (n,).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from serpenoid import group
from serpenoid.body import Floats
from serpenoid.gaits import Gait
from serpenoid.mechanics.tables import family_tables
from serpenoid.optimise.along import gaps_function
from serpenoid.optimise.asked import Customise, asked
from serpenoid.optimise.clearance import RESOLUTION, Clearance, clearance
from serpenoid.optimise.interrupt import StopFlag
from serpenoid.optimise.ipopt import Bounds, Ipopt, Outcome, Point
from serpenoid.optimise.limits import FIRST_ROWS, TOLERANCE, even_rows, exchange, path_limits, violations
from serpenoid.optimise.motion_law import motion_law
from serpenoid.optimise.softening import ITERATIONS, softer
from serpenoid.optimise.transcription import GaitNLP
from serpenoid.problem import Problem
from serpenoid.simulation import simulate_batch, simulate_joint_angles
from serpenoid.simulation.problem import gait_parameters
from serpenoid.simulation.rollout import Batch
from serpenoid.simulation.servos import realise_gait
from serpenoid.simulation.steps import shape_rows
from serpenoid.status import Status
from serpenoid.trajectory import Trajectory

EXCHANGES = 8  # of limit rows, and recoveries
RECOVERIES = 2
SLIPPED = 1e-3  # far above the tolerance of the poses (1e-8), far below another root (some tenths of a radian)
GaitBounds = tuple[Floats, Floats]


@dataclass(frozen=True)
class Answer:
    """IPOPT's outcome with the gait it found, total iterations over all exchanges, and the rows that carried limits.

    margin: what vertices kept from obstacles so that nothing comes too near between them; clearance: what is proven.
    """

    outcome: Outcome
    q: Floats
    iterations: int
    seconds: float
    rows: tuple[int, ...]
    margin: float = 0.0
    clearance: Clearance | None = None


class GaitSolver:
    """Prepared once per problem (structure, family, criteria); bounds and c may change per solve.

    gait: one of the family to optimise in; default the problem's own.
    """

    def __init__(self, problem: Problem, customise: Customise | None = None, gait: Gait | None = None) -> None:
        self.problem, self.model = problem, problem.model
        self.family = problem.family_of(gait)
        self.steps = self.family.rows - (not self.family.closed)
        self.asked = asked(problem.task, self.family, customise)
        self.limits = path_limits(problem)
        soft = softer(problem)
        self._softer = None if soft is None else GaitSolver(soft, customise, gait)
        self._prepared: dict[tuple[int, bool], tuple[GaitNLP, Ipopt]] = {}

    def gait_bounds(self) -> GaitBounds:
        """Lower and upper bounds of q: the problem's; joint limits too where the parameters are the angles."""
        lower, upper = self.family.limits
        if self.family.free:
            limit = np.tile(self.limits.upper[: self.family.joints], self.family.rows)
            lower, upper = np.maximum(lower, -limit), np.minimum(upper, limit)
        return lower, upper

    def own_start(self) -> Floats:
        """The problem's gait, inside the bounds."""
        return np.clip(gait_parameters(self.problem, self.family), *self.gait_bounds())

    def table(self, q: Floats) -> Floats:
        """Joint table (R, m) of gait parameters q."""
        return family_tables(self.model, self.family, q[None])[0]

    def tables(self, gaits: Floats) -> Floats:
        """Joint tables (B, R, m) of gaits (B, n)."""
        return family_tables(self.model, self.family, gaits)

    def finer(self, q: Floats, factor: int) -> Floats:
        """Joint table of gait q with `factor` times as many steps."""
        return family_tables(self.model, self.family.refined(factor), self.family.on_finer_rows(q, factor)[None])[0]

    def simulate(self, table: Floats) -> Trajectory:
        """The motion of one table."""
        return simulate_joint_angles(self.model, table, closed=self.family.closed)

    def batch(self, tables: Floats) -> Batch:
        """The motions of tables (B, R, m)."""
        return simulate_batch(self.model, tables, self.family.closed)

    def too_near(self, tables: Floats, batch: Batch, margin: float) -> Floats:
        """By how much vertices come nearer to obstacles than `margin`, summed over the rows: shape (B,)."""
        if not self.asked.criteria.clear_of:
            return np.zeros(len(tables))
        closed = self.family.closed
        angles = np.array([realise_gait(self.model, table) if closed else table for table in tables])
        rows = np.concatenate([angles, angles[:, :1]], axis=1) if closed else angles
        shapes, _ = shape_rows(self.model, rows.reshape(-1, rows.shape[2]))
        points = group.place(batch.poses.reshape(-1, 3), shapes)
        gaps = gaps_function(self.asked.criteria.clear_of, self.model.structure)
        value = gaps.map(len(points))(points.transpose(2, 0, 1).reshape(2, -1)).full()
        return np.maximum(margin - value, 0).sum(0).reshape(len(tables), -1).sum(1)

    def excess(self, tables: Floats) -> Floats:
        """How far joint angles and their changes exceed the limits, shape (B, rows, 2 m)."""
        return violations(tables, self.limits, self.family.closed)

    def prepare(self, q: Floats) -> None:
        """Compile what solving from gait q calls: done before Ctrl-C is caught, so that it ends a compile at once."""
        self.start(q)
        self.prepared(len(self._first_rows()))
        if self._softer is not None:
            self._softer.prepare(q)

    def _first_rows(self) -> list[int]:
        """Rows that carry limits: a few, exchanged later; of a sparse family all, where something is left to limit."""
        limited = self._limited
        if not limited.any():
            return []
        return list(range(self.steps)) if self.family.sparse else even_rows(self.steps, min(FIRST_ROWS, self.steps))

    @property
    def _limited(self) -> np.ndarray:
        """Which of a row's angles and changes (2 m) need a constraint."""
        finite = np.isfinite(self.limits.upper)
        if self.family.free:
            finite[: self.family.joints] = False
        return finite

    def start(self, q: Floats) -> Floats:
        """A start that satisfies all momentum equations: the simulated poses of gait q."""
        trajectory = self.simulate(self.table(q))
        poses = np.nan_to_num(trajectory.poses[1:] - trajectory.poses[0])
        lifted = [] if self.asked.criteria.separable else [trajectory.dissipation]
        return np.concatenate([poses.ravel(), np.nan_to_num(lifted), q])

    def solve(
        self,
        start: Floats | Point,
        c: float,
        gait_bounds: GaitBounds | None = None,
        rows: tuple[int, ...] = (),
        flag: StopFlag | None = None,
        watch: Callable[[float], None] | None = None,
    ) -> Answer:
        """Optimise from gait parameters (n,) or warm from a Point whose constraints had `rows`."""
        if self._softer is not None and not isinstance(start, Point):
            price = c if self._softer.model.law.degree == self.model.law.degree else 0.0  # drag has another scale
            soft = self._softer.solve(start, price, gait_bounds, (), flag)
            start = soft.q if soft.outcome.status.ok else start
        current: Floats | Point = start if isinstance(start, Point) else self.start(start)
        chosen = list(rows) or self._first_rows()
        iterations, seconds, recoveries, margin, clear = 0, 0.0, RECOVERIES, 0.0, None
        for _ in range(EXCHANGES):
            _, ipopt = self.prepared(len(chosen), penalised=c > 0 or self.asked.always_dissipation)
            parameters = self.parameters(c, chosen)
            outcome = ipopt.solve(current, parameters, self.bounds(chosen, gait_bounds, margin), flag, watch)
            iterations, seconds = iterations + outcome.iterations, seconds + outcome.timing["total"]
            q = outcome.point.x[-self.family.size :]
            again = self._recovery(outcome, gait_bounds) if recoveries else None
            if again is not None:
                recoveries, current = recoveries - 1, again
            elif outcome.status.ok and not self.family.sparse and self._violated(q):
                chosen, current = exchange(chosen, self.table(q), self.limits, self.steps), outcome.point.x
            elif outcome.status.ok and (clear := self.clearance(q)) is not None and clear.proven < 0:
                margin, current = margin - clear.proven + RESOLUTION, outcome.point.x
            else:
                break
        return Answer(outcome, q, iterations, seconds, tuple(chosen), margin, clear)

    def clearance(self, q: Floats) -> Clearance | None:
        """How near gait q comes to obstacles at any time, None where there are none."""
        gaps = self.asked.criteria.clear_of
        if not gaps:
            return None
        table = self.table(q)
        angles = realise_gait(self.model, table) if self.family.closed else table
        rows = np.concatenate([angles, angles[:1]]) if self.family.closed else angles
        return clearance(self.model, self.simulate(table).poses, rows, gaps)

    def _violated(self, q: Floats) -> bool:
        return self.limits.any and float(self.excess(self.tables(q[None])).max()) > TOLERANCE

    def _recovery(self, outcome: Outcome, gait_bounds: GaitBounds | None) -> Floats | None:
        """A new start where IPOPT went astray, else None.

        A pose may have slipped to another root of its step (an energy maximum, say): the gait is simulated anew. Or
        the search ended at a gait that does not move, where the displacement has a kink: it is opened.
        """
        q = outcome.point.x[-self.family.size :]
        if not np.isfinite(q).all() or outcome.status not in (Status.SOLVED, Status.NOT_CONVERGED):
            return None
        simulated = self.start(q)
        if np.abs(simulated - outcome.point.x).max() > SLIPPED:
            return simulated
        if outcome.status is Status.NOT_CONVERGED:
            opened = np.clip(self.family.opened(q), *(gait_bounds or self.gait_bounds()))
            return None if (opened == q).all() else self.start(opened)
        return None

    def prepared(self, path_rows: int, penalised: bool = True) -> tuple[GaitNLP, Ipopt]:
        """The NLP with `path_rows` limit rows, with or without dissipation in the objective, and its solver."""
        key = path_rows, penalised
        if key not in self._prepared:
            law = motion_law(self.model, self.family)
            nlp = GaitNLP(law, self.asked.criteria, path_rows, penalised=penalised)
            limited = np.tile(self._limited, path_rows)
            motion, _, added = nlp.constraint_counts
            kept = np.concatenate([np.full(motion, True), limited, np.full(added, True)])
            options = None if self._softer is None else {"ipopt.max_iter": ITERATIONS}
            self._prepared[key] = nlp, Ipopt(nlp, np.flatnonzero(kept), options)
        return self._prepared[key]

    def parameters(self, c: float, rows: list[int]) -> Floats:
        """Numbers for the NLP's parameters."""
        data = np.concatenate([self.family.data, self.family.data[:1]])
        ends = np.hstack([data[rows], data[np.array(rows, int) + 1]])
        return np.concatenate([[c], ends.ravel(), self.model.parameters])

    def bounds(self, rows: list[int], gait_bounds: GaitBounds | None = None, margin: float = 0.0) -> Bounds:
        """Bounds of all variables and constraints; vertices keep `margin` from obstacles."""
        lower, upper = gait_bounds or self.gait_bounds()
        nlp, _ = self.prepared(len(rows))
        n = 3 * self.steps
        lbx = np.concatenate([np.full(n + nlp.lifted, -np.inf), lower])
        ubx = np.concatenate([np.full(n + nlp.lifted, np.inf), upper])
        turn = self.heading_target()
        if turn is not None:
            lbx[n - 1] = ubx[n - 1] = turn
        path, zero = np.tile(self.limits.upper, len(rows)), np.zeros(n + nlp.lifted)
        least, most = self.asked.bounds
        gaps = nlp.constraint_counts[2] - least.size
        least, most = np.append(least, np.full(gaps, margin)), np.append(most, np.full(gaps, np.inf))
        return Bounds(lbx, ubx, np.concatenate([zero, -path, least]), np.concatenate([zero, path, most]))

    def heading_target(self) -> float | None:
        """Prescribed heading change [rad], None where it is free."""
        constraints = self.problem.task.constraints
        return 0.0 if constraints.straight else constraints.heading_change_rad
