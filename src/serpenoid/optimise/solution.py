"""A certified (or refused) optimal gait, and how it was reached."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from serpenoid.body import Floats
from serpenoid.gaits import Gait
from serpenoid.objectives.term import NOTHING, told
from serpenoid.optimise.circle import circle_note
from serpenoid.optimise.clear.apart import Pairs
from serpenoid.optimise.clear.clearance import Clearance
from serpenoid.optimise.ipopt import Residuals
from serpenoid.optimise.unmoved import rest_note, why_unmoved
from serpenoid.problem import Problem
from serpenoid.shown import Shown
from serpenoid.simulation.mesh import MeshStudy
from serpenoid.status import Status
from serpenoid.trajectory import Trajectory

AT_BOUND = 1e-6  # of a range


@dataclass(frozen=True)
class CaseOutcome:
    """What a robust gait does in one of its cases; value: its objective there."""

    name: str
    weight: float
    value: float
    trajectory: Trajectory


@dataclass(frozen=True)
class SelfClear(Clearance):
    """Clearance of the body from itself, and what is wanted of it [body lengths]."""

    wanted: float

    @property
    def goal(self) -> str:
        """Whether it is met, or by how much it is missed, in words."""
        proven = self.proven >= self.wanted - NOTHING or self.least < self.wanted - NOTHING
        words = told("distance from itself", max(self.wanted - self.least, 0.0))
        return words if proven else f"{words} where it was looked, but not proven between"

    @classmethod
    def of(cls, pairs: Pairs, wanted: float, table: Floats, closed: bool) -> SelfClear:
        """Of a commanded joint table, proven at every time."""
        found = pairs.clearance(pairs.realised(table, closed), wanted)
        return cls(found.least, found.proven, wanted)


@dataclass(frozen=True, repr=False, eq=False)
class Solution(Shown):
    """An optimal gait; `trajectory` is its re-simulation, `table` (R, m) its joint angles [rad].

    cost: the objective, with the user's own terms where there are any, from the re-simulation; `objective`: what the
    optimiser minimised. clearance: from obstacles, if there are any; fine_clearance:
    the same of the mesh certificate's finest motion. names, q: the family's parameters (n,). cases:
    those that a robust gait serves; `cost` is then over all of them, `trajectory` is in the problem's own medium.
    rest_is_as_good: a straight body that never moves meets all that is asked at the same cost.
    missed: of a failure, by how much the gait as it is simulated misses limits and demands together.
    """

    status: Status
    problem: Problem
    c: float
    gait: Gait
    names: tuple[str, ...]
    q: Floats
    table: Floats
    trajectory: Trajectory
    cost: float
    objective: float
    residuals: Residuals
    resimulation_error: float
    polishing_gain: float | None
    clearance: Clearance | None
    mesh: MeshStudy
    ipopt_status: str
    iterations: int
    seconds: float = field(compare=False)
    timing: dict[str, float] = field(compare=False)
    cases: tuple[CaseOutcome, ...] = ()
    fine_clearance: Clearance | None = None
    self_clearance: SelfClear | None = None
    rest_is_as_good: bool = False
    missed: float = 0.0

    @property
    def at_bounds(self) -> tuple[str, ...]:
        """Parameters of the gait that ended where the file ends the search: a wider range may hold a better one."""
        family = self.problem.family_of(self.gait)
        ended = (
            (family.ended_at(name, end), end)
            for name, q, low, high in zip(self.names, self.q, *family.limits, strict=True)
            for end in (low, high)
            if abs(q - end) < AT_BOUND * (high - low)
        )
        return tuple(f"{name} = {end:g}" for name, end in ended if name is not None)

    @property
    def message(self) -> str:
        """How it ended; of a failure that no other start can mend, why."""
        if self.status in (Status.SOLVED, Status.STOPPED):
            return self.status.value
        return why_unmoved(self.problem) or self.status.value

    @property
    def note(self) -> str | None:
        """What is to be known of an optimum that rest equals, or that leads round a circle; None: nothing."""
        if not self.status.ok:
            return None
        turn = self.trajectory.heading_change
        return rest_note(self.problem, self.c) if self.rest_is_as_good else circle_note(self.problem, turn)

    @property
    def headline_note(self) -> str | None:
        """Of a robust gait, in which medium `trajectory` is; None of any other."""
        if self.problem.task.robust is None:
            return None
        own = f"the problem's own medium (anisotropy ratio {self.problem.medium.anisotropy_ratio:g})"
        same = (case.name for case in self.cases if np.array_equal(case.trajectory.poses, self.trajectory.poses))
        return f"in {own}, {f'the case {name}' if (name := next(same, None)) else 'which is none of the cases'}"

    def summary(self) -> str:
        """How it ended, and how far the gait goes for what."""
        went = f"{self.trajectory.displacement:.6f} body lengths, cost {self.cost:.6f} at c = {self.c:g}"
        said = f"{self.problem.name}: {self.status.name.lower()}, {went}"
        said += "" if self.headline_note is None else f"; displacement {self.headline_note}"
        return said if self.note is None else f"{said}; {self.note}"
