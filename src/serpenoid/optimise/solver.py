"""One gait optimisation: NLP, start, limits, IPOPT, from a start gait to a primal-dual answer. No certificate yet.

Legend: T steps, m joints, K path rows, q gait parameters (n,).
"""

from __future__ import annotations

from collections.abc import Callable, Set
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from serpenoid.body import Floats
from serpenoid.gaits import Gait
from serpenoid.mechanics.tables import family_tables
from serpenoid.optimise.asked import Customise, asked
from serpenoid.optimise.clearance import RESOLUTION, Clearance
from serpenoid.optimise.coarse import FACTOR, coarser, on_coarser_rows
from serpenoid.optimise.interrupt import StopFlag
from serpenoid.optimise.ipopt import Bounds, Ipopt, Outcome, Point
from serpenoid.optimise.limits import FIRST_ROWS, TOLERANCE, even_rows, exchange, path_limits, violations
from serpenoid.optimise.mesh import MeshStudy, study_mesh
from serpenoid.optimise.motion_law import motion_law, needs_states
from serpenoid.optimise.obstacles import Obstacles
from serpenoid.optimise.played import Played
from serpenoid.optimise.softening import ITERATIONS, softer
from serpenoid.optimise.solution import CaseOutcome
from serpenoid.optimise.transcription import GaitNLP
from serpenoid.optimise.watch import MARGIN, Watch
from serpenoid.problem import Problem
from serpenoid.simulation import simulate_batch, simulate_joint_angles
from serpenoid.simulation.problem import gait_parameters
from serpenoid.simulation.rollout import Batch
from serpenoid.status import Status
from serpenoid.trajectory import Trajectory

EXCHANGES = 16  # of limit rows and watched points, and recoveries
MOST_PREPARED = 6  # NLPs kept for another start
RECOVERIES = 2
SLIPPED = 1e-3  # far above the tolerance of the poses (1e-8), far below another root (some tenths of a radian)
GaitBounds = tuple[Floats, Floats]


@dataclass(frozen=True)
class Carried:
    """What an NLP carries of conditions at all times: rows with limits, points watched for obstacles, their margin.

    staying: rows that bound or were violated in this solve.
    """

    rows: tuple[int, ...] = ()
    watch: Watch = Watch()
    margin: float = MARGIN
    staying: Set[int] = frozenset()


@dataclass(frozen=True)
class Answer:
    """IPOPT's outcome with the gait it found, total iterations over all exchanges, and what the last NLP carried.

    clearance: what is proven of obstacles.
    """

    outcome: Outcome
    q: Floats
    iterations: int
    seconds: float
    carried: Carried
    clearance: Clearance | None = None


@dataclass(frozen=True)
class Costs:
    """value: objectives (B,); outside: sums of the violations (B,); sound: whether gaits could be simulated (B,)."""

    value: Floats
    outside: Floats
    sound: np.ndarray
    batch: Batch | None = None


class GaitSolver:
    """Prepared once per problem (structure, family, criteria); bounds and c may change per solve.

    gait: one of the family to optimise in; default the problem's own.
    """

    def __init__(self, problem: Problem, customise: Customise | None = None, gait: Gait | None = None) -> None:
        self.problem, self.model = problem, problem.model
        self.family = problem.family_of(gait)
        self.steps = self.family.rows - (not self.family.closed)
        self.asked = asked(problem.task, self.family, customise, self.model)
        self.limits = path_limits(problem)
        soft = softer(problem)
        self._softer = None if soft is None else GaitSolver(soft, customise, gait)
        rough = coarser(problem, self.family) if gait is None and customise is None and soft is None else None
        self._coarser = None if rough is None else GaitSolver(rough)
        gaps = tuple(self.asked.criteria.clear_of)
        self.obstacles = Obstacles(gaps, self.model, self.steps, self.family.closed)
        self._prepared: dict[tuple[int, bool, Watch], tuple[GaitNLP, Ipopt]] = {}

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

    def costs(self, tables: Floats, gaits: Floats, c: float) -> Costs:
        """Objective, violations of what is asked, and soundness of gaits (B, n) with these tables, simulated."""
        batch = self.batch(tables)
        value, outside = self.asked.evaluate(batch, tables, gaits, c)
        target = self.heading_target()
        if target is not None:
            outside = outside + np.abs(batch.poses[:, -1, 2] - target)
        return Costs(value, outside, batch.sound, batch)

    def value(self, q: Floats, table: Floats, trajectory: Trajectory, c: float) -> float:
        """The objective of a simulated gait; not a number where the simulation failed."""
        poses, dissipation = trajectory.poses[None], np.array([trajectory.dissipation])
        batch = Batch(poses, dissipation, np.array([trajectory.residual]), np.array([trajectory.status.ok]))
        return float(self.asked.evaluate(batch, table[None], q[None], c)[0][0])

    def pose_error(self, point: Point, table: Floats, trajectory: Trajectory) -> float:
        """Largest difference between the poses of the NLP and those of the simulation."""
        poses = point.x[: 3 * self.steps].reshape(-1, 3)
        return float(np.max(np.abs(trajectory.poses[1:] - poses)))

    def meshes(self, q: Floats) -> list[MeshStudy]:
        """How the motion depends on the number of steps."""
        return [study_mesh(lambda factor: self.simulate(self.finer(q, factor)), self.steps)]

    def outcomes(self, q: Floats, c: float) -> tuple[CaseOutcome, ...]:
        """What gait q does in every case that it must serve; of one model: nothing more to say."""
        return ()

    def excess(self, tables: Floats) -> Floats:
        """How far joint angles and their changes exceed the limits, shape (..., rows, 2 m); -infinity without any."""
        return violations(tables, self.limits, self.family.closed)

    def prepare(self, q: Floats) -> None:
        """Compile what solving from gait q calls: done before Ctrl-C is caught, so that it ends a compile at once."""
        self.start(q)
        self.prepared(self.first())
        if self._softer is not None:
            self._softer.prepare(q)
        if self._coarser is not None:
            self._coarser.prepare(on_coarser_rows(q, self.family))

    def first(self) -> Carried:
        """What the first NLP of a search carries."""
        return Carried(tuple(self._first_rows()), self.obstacles.first())

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
        states = np.zeros(0) if self._played is None else self._played.start(self.table(q))
        return np.concatenate([poses.ravel(), np.nan_to_num(lifted), states, q])

    @property
    def states(self) -> int:
        """Numbers of the servos' memories in the NLP."""
        return 0 if self._played is None else self._played.states

    @cached_property
    def _played(self) -> Played | None:
        """Servos whose memories are variables of the NLP."""
        return Played(self.model, self.family) if needs_states(self.model, self.family) else None

    def solve(
        self,
        start: Floats | Point,
        c: float,
        gait_bounds: GaitBounds | None = None,
        carried: Carried | None = None,
        flag: StopFlag | None = None,
        watch: Callable[[float], None] | None = None,
    ) -> Answer:
        """Optimise from gait parameters (n,) or warm from a Point of an NLP that had `carried`."""
        if self._softer is not None and not isinstance(start, Point):
            price = c if self._softer.model.law.degree == self.model.law.degree else 0.0  # drag has another scale
            soft = self._softer.solve(start, price, gait_bounds, None, flag)
            start = soft.q if soft.outcome.status.ok else start
        iterations, seconds = 0, 0.0
        if self._coarser is not None and gait_bounds is None and not isinstance(start, Point):
            rough = self._coarser.solve(on_coarser_rows(start, self.family), c, flag=flag)
            iterations, seconds = rough.iterations, rough.seconds
            finer = np.clip(self._coarser.family.on_finer_rows(rough.q, FACTOR), *self.gait_bounds())
            start = finer if rough.outcome.status.ok else start
        current: Floats | Point = start if isinstance(start, Point) else self.start(start)
        carried, recoveries, clear = replace(carried or self.first(), staying=frozenset()), RECOVERIES, None
        for _ in range(EXCHANGES):
            _, ipopt = self.prepared(carried, penalised=c > 0 or self.asked.always_dissipation)
            outcome = ipopt.solve(
                current, self.parameters(c, carried.rows), self.bounds(carried, gait_bounds), flag, watch
            )
            iterations, seconds = iterations + outcome.iterations, seconds + outcome.timing["total"]
            q = outcome.point.x[-self.family.size :]
            again = self._recovery(outcome, gait_bounds) if recoveries else None
            if again is not None:
                recoveries, current = recoveries - 1, again
                continue
            following, clear = self._exchanged(carried, q) if outcome.status.ok else (carried, None)
            if following == carried:
                break
            same_rows = carried.rows == following.rows
            current = self._moved(outcome.point, carried, following) if same_rows else outcome.point.x
            carried = following
        return Answer(outcome, q, iterations, seconds, carried, clear)

    def _moved(self, point: Point, before: Carried, after: Carried) -> Point:
        """The point with multipliers for the next NLP, whose watched points are others."""
        size = self.model.structure.vertices, self.obstacles.field.convex.size
        old, new = before.watch.places(*size), after.watch.places(*size)
        nlp, _ = self.prepared(after)
        lam_g = np.zeros(sum(nlp.constraint_counts))
        first = lam_g.size - len(after.watch.instants) * size[0] * size[1]
        lam_g[:first] = point.lam_g[:first]
        for watched in old.keys() & new.keys():
            lam_g[first + new[watched]] = point.lam_g[first + old[watched]]
        return Point(point.x, point.lam_x, lam_g)

    def _exchanged(self, carried: Carried, q: Floats) -> tuple[Carried, Clearance | None]:
        """What the next NLP must carry, the same where gait q keeps all limits and clear of obstacles, as is proven."""
        table = self.table(q)
        excess = self.excess(table)
        if not self.family.sparse and float(excess.max()) > TOLERANCE:
            rows, staying = exchange(carried.rows, carried.staying, excess)
            return replace(carried, rows=tuple(rows), staying=staying), None
        if not self.obstacles.gaps:
            return carried, None
        poses = self.simulate(table).poses
        watch = self.obstacles.after(carried.watch, poses, table, carried.margin)
        if set(watch.points) - set(carried.watch.points):
            return replace(carried, watch=watch), None
        clear = self.obstacles.clearance(poses, table)
        if clear is None or clear.proven >= 0:
            return carried, clear
        return replace(carried, watch=watch, margin=carried.margin - clear.proven + RESOLUTION), clear

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

    def prepared(self, carried: Carried, penalised: bool = True) -> tuple[GaitNLP, Ipopt]:
        """The NLP that carries this, with or without dissipation in the objective, and its solver."""
        rows, watch = len(carried.rows), carried.watch
        key = rows, penalised, watch
        if key not in self._prepared:
            law = motion_law(self.model, self.family)
            nlp = GaitNLP(law, self.asked.criteria, rows, penalised=penalised, watch=watch)
            motion, path, added = nlp.constraint_counts
            columns = self.obstacles.field.convex.size if watch.points else 0
            gaps = watch.kept(self.model.structure.vertices, columns)
            others = motion + path + self.asked.bounds[0].size
            kept = np.concatenate([np.arange(motion), motion + np.flatnonzero(np.tile(self._limited, rows)),
                                   np.arange(motion + path, others), others + gaps])  # fmt: skip
            options = None if self._softer is None else {"ipopt.max_iter": ITERATIONS}
            while len(self._prepared) >= MOST_PREPARED:
                del self._prepared[next(iter(self._prepared))]
            self._prepared[key] = nlp, Ipopt(nlp, kept, options)
        return self._prepared[key]

    def parameters(self, c: float, rows: tuple[int, ...]) -> Floats:
        """Numbers for the NLP's parameters."""
        data = np.concatenate([self.family.data, self.family.data[:1]])
        chosen = np.array(rows, int)
        ends = np.hstack([data[chosen], data[chosen + 1]])
        return np.concatenate([[c], ends.ravel(), self.model.parameters])

    def bounds(self, carried: Carried, gait_bounds: GaitBounds | None = None) -> Bounds:
        """Bounds of all variables and constraints."""
        lower, upper = gait_bounds or self.gait_bounds()
        nlp, _ = self.prepared(carried)
        n = 3 * self.steps
        own = np.full(nlp.variables.numel() - self.family.size, np.inf)
        lbx, ubx = np.concatenate([-own, lower]), np.concatenate([own, upper])
        turn = self.heading_target()
        if turn is not None:
            lbx[n - 1] = ubx[n - 1] = turn
        path, zero = np.tile(self.limits.upper, len(carried.rows)), np.zeros(nlp.constraint_counts[0])
        least, most = self.asked.bounds
        gaps = nlp.constraint_counts[2] - least.size
        free = np.full(gaps, -np.inf)
        free[carried.watch.kept(self.model.structure.vertices, self.obstacles.field.convex.size)] = carried.margin
        least, most = np.append(least, free), np.append(most, np.full(gaps, np.inf))
        return Bounds(lbx, ubx, np.concatenate([zero, -path, least]), np.concatenate([zero, path, most]))

    def heading_target(self) -> float | None:
        """Prescribed heading change [rad], None where it is free."""
        constraints = self.problem.task.constraints
        return 0.0 if constraints.straight else constraints.heading_change_rad
