"""A certified (or refused) optimal gait, and how it was reached."""

from __future__ import annotations

from dataclasses import dataclass

from serpenoid.body import Floats
from serpenoid.gaits import EllipseGait
from serpenoid.optimise.ipopt import Residuals
from serpenoid.optimise.mesh import MeshStudy
from serpenoid.problem import Problem
from serpenoid.status import Status
from serpenoid.trajectory import Trajectory


@dataclass(frozen=True)
class Solution:
    """An optimal gait; `trajectory` is its re-simulation, `table` (T, m) its joint angles [rad].

    cost = -displacement + c * dissipation, from the re-simulation; `objective` is what the optimiser minimised, with
    the user's own terms where there are any.
    """

    status: Status
    problem: Problem
    c: float
    gait: EllipseGait
    table: Floats
    trajectory: Trajectory
    objective: float
    residuals: Residuals
    resimulation_error: float
    polishing_gain: float | None
    mesh: MeshStudy
    ipopt_status: str
    iterations: int
    seconds: float
    timing: dict[str, float]

    @property
    def cost(self) -> float:
        """-Delta + c * dissipation."""
        return -self.trajectory.displacement + self.c * self.trajectory.dissipation
