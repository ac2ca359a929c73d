"""Gaits whose body keeps off itself: an exchange method over times and pairs of vertices and edges.

A first NLP knows nothing of it. Pairs that come too near in its answer are constraints of the next, until none is left
and the whole motion is proven; small deficits between the times that are looked at widen the margin. Where edges cross,
no small step undoes it: the next NLP begins where the first did, apart.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.gaits import Gait
from serpenoid.objectives.criteria import Criteria
from serpenoid.optimise.asked import Customise
from serpenoid.optimise.clear.apart import Near, keep_apart, pairs_of
from serpenoid.optimise.clear.clearance import RESOLUTION
from serpenoid.optimise.ipopt import Point
from serpenoid.optimise.motions import Costs
from serpenoid.optimise.solution import SelfClear
from serpenoid.optimise.solver import AS_ASKED, Answer, GaitSolver, Run
from serpenoid.problem import Problem
from serpenoid.status import Status

ROUNDS = 12
SMALLER = 20  # times a start's angles are multiplied by 0.8: nearly straight
MARGIN = 1e-3  # body lengths more than asked for at the times that are watched: finer than a robot is placed


class ApartSolver(GaitSolver):
    """A GaitSolver whose answers keep off themselves."""

    def __init__(self, problem: Problem, customise: Customise | None = None, gait: Gait | None = None) -> None:
        super().__init__(problem, customise, gait)
        self._customise, self._gait = customise, gait
        asked = pairs_of(self.model, problem.task.demands)
        if asked is None:
            raise InputError("nothing asks the body to keep off itself. Add a demand of kind `self`.")
        self.pairs, self.distance = asked

    def solve(self, start: Floats | Point, c: float, run: Run = AS_ASKED) -> Answer:
        """As a GaitSolver's, until nothing is too near."""
        begin = self._clear_start(start.x[-self.family.size :] if isinstance(start, Point) else start)
        answer = super().solve(begin, c, run)
        watched: tuple[Near, ...] = ()
        margin = MARGIN
        for _ in range(ROUNDS):
            angles = self._angles(self.table(answer.q))
            if run.flag or not np.isfinite(angles).all():
                break
            near = set(self.pairs.near(angles, self.distance + 0.5 * margin)) - set(watched)
            proven = 0.0 if near else self.pairs.clearance(angles, self.distance).proven
            if not near and proven >= self.distance:
                break
            margin += 0.0 if near else self.distance - proven + RESOLUTION
            watched = (*watched, *sorted(near))
            alone = GaitSolver(self.problem, self._with(watched, margin), self._gait)
            apart = self.pairs.least(angles[None])[0] > 0
            again = alone.solve(answer.q if apart else begin, c, replace(run, carried=None))
            answer = again.after(answer)
            if again.outcome.status is Status.STOPPED:
                break
        return answer

    def _clear_start(self, q: Floats) -> Floats:
        """The start, with smaller joint angles where it comes too near to itself."""
        for _ in range(SMALLER):
            if self.pairs.least(self._angles(self.table(q))[None])[0] > self.distance:
                break
            q = self.family.scaled(q, 0.8)
        return q

    def costs(self, tables: Floats, gaits: Floats, c: float) -> Costs:
        """With what the body comes too near to itself, at rows."""
        found = super().costs(tables, gaits, c)
        least = self.pairs.least(np.array([self._angles(table) for table in tables]))
        return replace(found, outside=found.outside + np.maximum(self.distance - least, 0))

    def self_clearance(self, table: Floats) -> SelfClear | None:
        """Proven at every time."""
        return SelfClear.of(self.pairs, self.distance, table, self.family.closed)

    def _angles(self, table: Floats) -> Floats:
        """Realised joint angles of rows 0 .. T."""
        return self.pairs.realised(table, self.family.closed)

    def _with(self, watched: tuple[Near, ...], margin: float) -> Customise:
        def customise(of: Criteria) -> None:
            if self._customise is not None:
                self._customise(of)
            keep_apart(of, self.model, watched, self.distance + margin)

        return customise
