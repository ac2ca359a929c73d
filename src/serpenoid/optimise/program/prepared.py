"""The NLPs of a problem, each prepared once: with rows that carry limits and points that are watched for obstacles.

Legend: T steps, m joints, K path rows, q gait parameters (n,).
"""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.gaits import Gait
from serpenoid.optimise.asked import Customise
from serpenoid.optimise.clear.watch import MARGIN, Watch
from serpenoid.optimise.ipopt import BESIDE_OBSTACLES, Bounds, Ipopt
from serpenoid.optimise.motions import GaitBounds, GaitMotions
from serpenoid.optimise.program.limits import FIRST_ROWS, even_rows
from serpenoid.optimise.program.transcription import GaitNLP
from serpenoid.optimise.step.motion_law import MotionLaw, motion_law
from serpenoid.problem import Problem

MOST_PREPARED = 6  # NLPs kept for another start


@dataclass(frozen=True)
class Carried:
    """What an NLP carries of conditions at all times: rows with limits, points watched for obstacles, their margin.

    staying: rows that bound or were violated in this solve.
    """

    rows: tuple[int, ...] = ()
    watch: Watch = Watch()
    margin: float = MARGIN
    staying: Set[int] = frozenset()


class PreparedNLPs(GaitMotions):
    """NLPs by what they carry, with their solvers; options: of IPOPT, for all of them."""

    def __init__(self, problem: Problem, customise: Customise | None, gait: Gait | None, options: dict) -> None:
        super().__init__(problem, customise, gait)
        self._enough_parameters()
        self._options = options
        self._prepared: dict[tuple[int, bool, Watch], tuple[GaitNLP, Ipopt]] = {}

    def _enough_parameters(self) -> None:
        """InputError where more numbers are asked for than the family has parameters to meet them with."""
        least, most = self.asked.bounds
        asked, size = int((least == most).sum()), self.family.size
        if asked > size:
            raise InputError(
                f"[gait] family: must have as many parameters as the demands fix numbers, got {size} "
                f"(`{self.family.like.family}`) for {asked}. Take a larger family (spline, table), or "
                "demand less."
            )

    def first(self) -> Carried:
        """What the first NLP of a search carries."""
        return Carried(tuple(self._first_rows()), self.obstacles.first())

    def on_every_row(self, carried: Carried) -> Carried:
        """The same with limits on all rows."""
        return replace(carried, rows=tuple(range(self.steps)))

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

    @cached_property
    def _law(self) -> MotionLaw:
        return motion_law(self.model, self.family)

    def prepared(self, carried: Carried, penalised: bool = True) -> tuple[GaitNLP, Ipopt]:
        """The NLP that carries this, with or without dissipation in the objective, and its solver."""
        rows, watch = len(carried.rows), carried.watch
        key = rows, penalised, watch
        if key not in self._prepared:
            nlp = GaitNLP(self._law, self.asked.criteria, rows, penalised=penalised, watch=watch)
            motion, path, added = nlp.constraint_counts
            gaps = watch.kept(self.model.structure.vertices, self.obstacles.columns)
            others = motion + path + self.asked.bounds[0].size
            kept = np.concatenate([np.arange(motion), motion + np.flatnonzero(np.tile(self._limited, rows)),
                                   np.arange(motion + path, others), others + gaps])  # fmt: skip
            options = self._options | (BESIDE_OBSTACLES if watch.points else {})
            while len(self._prepared) >= MOST_PREPARED:
                del self._prepared[next(iter(self._prepared))]
            self._prepared[key] = nlp, Ipopt(nlp, kept, options, self.family.pose_size * self.steps)
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
        own, size = self.own, (self.model.structure.vertices, self.obstacles.columns)
        lbx, ubx = np.concatenate([np.full(own, -np.inf), lower]), np.concatenate([np.full(own, np.inf), upper])
        turn = self.heading_target()
        if turn is not None:
            last = self.family.pose_size * (self.steps - 1) + 2  # the heading of the last pose
            lbx[last] = ubx[last] = turn
        (low, high), zero = self.limits.of_rows(len(carried.rows)), np.zeros(own)
        least, most = self.asked.bounds
        gaps = np.full(carried.watch.count(*size), -np.inf)
        gaps[carried.watch.kept(*size)] = carried.margin
        least, most = np.append(least, gaps), np.append(most, np.full(gaps.size, np.inf))
        return Bounds(lbx, ubx, np.concatenate([zero, low, least]), np.concatenate([zero, high, most]))
