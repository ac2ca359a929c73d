"""One gait optimisation: NLP, start, limits, IPOPT, from a start gait to a primal-dual answer. No certificate yet.

Legend: T steps, m joints, K path rows, q gait parameters (6,).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from serpenoid.body import Floats
from serpenoid.gaits import EllipseGait
from serpenoid.mechanics.tables import joint_table
from serpenoid.optimise.extended import ExtendedNLP
from serpenoid.optimise.interrupt import StopFlag
from serpenoid.optimise.ipopt import Bounds, Ipopt, Outcome, Point
from serpenoid.optimise.limits import FIRST_ROWS, TOLERANCE, even_rows, exchange, path_limits, worst_violation
from serpenoid.optimise.transcription import GaitNLP
from serpenoid.problem import Problem
from serpenoid.simulation import simulate_joint_angles

EXCHANGES = 8
Customise = Callable[[GaitNLP], None]
GaitBounds = tuple[Floats, Floats]


@dataclass(frozen=True)
class Answer:
    """IPOPT's outcome with the gait it found, total iterations over all exchanges, and the rows that carried limits."""

    outcome: Outcome
    q: Floats
    iterations: int
    seconds: float
    rows: tuple[int, ...]


class GaitSolver:
    """Prepared once per problem (structure, steps, switched-on constraints); bounds and c may change per solve."""

    def __init__(self, problem: Problem, customise: Customise | None = None) -> None:
        self.problem, self.model = problem, problem.model
        self.steps = problem.task.steps
        self.limits = path_limits(problem)
        self.customise = customise
        self._prepared: dict[tuple[int, bool], tuple[GaitNLP, Ipopt]] = {}

    def gait_bounds(self) -> GaitBounds:
        """Lower and upper bounds of q from the problem, theta unbounded unless given."""
        bounds = self.problem.task.bounds
        free = (-np.inf, np.inf)
        pairs = np.array([getattr(bounds, name) or free for name in EllipseGait.NAMES], float)
        frequency = self.problem.task.constraints.spatial_frequency
        if frequency is not None:
            pairs[EllipseGait.NAMES.index("xi")] = frequency
        return pairs[:, 0], pairs[:, 1]

    def prepare(self, q: Floats) -> None:
        """Compile what solving from gait q calls: done before Ctrl-C is caught, so that it ends a compile at once."""
        self.start(q)
        self.prepared(len(self._first_rows()))

    def _first_rows(self) -> list[int]:
        return even_rows(self.steps, min(FIRST_ROWS, self.steps)) if self.limits.any else []

    def start(self, q: Floats) -> Floats:
        """A start that satisfies all momentum equations: the simulated poses of gait q."""
        trajectory = simulate_joint_angles(self.model, joint_table(self.model, q, self.steps))
        poses = np.nan_to_num(trajectory.poses[1:] - trajectory.poses[0])
        return np.concatenate([poses.ravel(), q])

    def solve(
        self,
        start: Floats | Point,
        c: float,
        gait_bounds: GaitBounds | None = None,
        rows: tuple[int, ...] = (),
        flag: StopFlag | None = None,
        watch: Callable[[float], None] | None = None,
    ) -> Answer:
        """Optimise from gait parameters (6,) or warm from a Point whose constraints had `rows`."""
        current: Floats | Point = start if isinstance(start, Point) else self.start(start)
        chosen = list(rows) or self._first_rows()
        iterations, seconds = 0, 0.0
        for _ in range(EXCHANGES):
            _, ipopt = self.prepared(len(chosen), penalised=c > 0)
            parameters = self.parameters(c, chosen)
            outcome = ipopt.solve(current, parameters, self.bounds(chosen, gait_bounds), flag, watch)
            iterations, seconds = iterations + outcome.iterations, seconds + outcome.timing["total"]
            q = outcome.point.x[-6:]
            table = joint_table(self.model, q, self.steps)
            if not outcome.status.ok or worst_violation(table, self.limits) <= TOLERANCE:
                break
            chosen, current = exchange(chosen, table, self.limits, self.steps), outcome.point.x
        return Answer(outcome, q, iterations, seconds, tuple(chosen))

    def prepared(self, path_rows: int, penalised: bool = True) -> tuple[GaitNLP, Ipopt]:
        """The NLP with `path_rows` limit rows, with or without dissipation in the objective, and its solver."""
        key = path_rows, penalised
        if key not in self._prepared:
            extended = self.model.medium_effects or self.model.actuation_effects
            kind = partial(ExtendedNLP, self.model) if extended else partial(GaitNLP, self.model.structure)
            nlp: GaitNLP = kind(self.steps, path_rows)
            nlp.penalised = penalised
            if self.customise is not None:
                self.customise(nlp)
            limited = np.tile(np.isfinite(self.limits.upper), path_rows)
            momentum, _, added = nlp.constraint_counts
            kept = np.concatenate([np.full(momentum, True), limited, np.full(added, True)])
            self._prepared[key] = nlp, Ipopt(nlp, np.flatnonzero(kept))
        return self._prepared[key]

    def parameters(self, c: float, rows: list[int]) -> Floats:
        """Numbers for the NLP's parameters."""
        return np.concatenate([[c], np.array(rows) / self.steps, self.model.parameters])

    def bounds(self, rows: list[int], gait_bounds: GaitBounds | None = None) -> Bounds:
        """Bounds of all variables and constraints."""
        lower, upper = gait_bounds or self.gait_bounds()
        n = 3 * self.steps
        lbx, ubx = np.concatenate([np.full(n, -np.inf), lower]), np.concatenate([np.full(n, np.inf), upper])
        turn = self.heading_target()
        if turn is not None:
            lbx[n - 1] = ubx[n - 1] = turn
        nlp, _ = self.prepared(len(rows))
        path = np.tile(self.limits.upper, len(rows))
        added = [(np.full(e.numel(), lo), np.full(e.numel(), hi)) for e, lo, hi in nlp.added]
        lbg = np.concatenate([np.zeros(n), -path, *(lo for lo, _ in added)])
        ubg = np.concatenate([np.zeros(n), path, *(hi for _, hi in added)])
        return Bounds(lbx, ubx, lbg, ubg)

    def heading_target(self) -> float | None:
        """Prescribed heading change [rad], None where it is free."""
        constraints = self.problem.task.constraints
        return 0.0 if constraints.straight else constraints.heading_change_rad
