"""A simulated (or re-simulated) motion: poses, vertices and step energies, in body lengths and cycles.

Legend: R rows (T + 1 for one cycle of T steps), N vertices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.shown import Shown
from serpenoid.status import Status


@dataclass(frozen=True, repr=False)
class Trajectory(Shown):
    """Motion of the body frame (weighted centroid, mean edge angle) and of every vertex.

    poses (R, 3): x, y [body lengths], heading [rad]; vertices (R, N, 2) [body lengths]; step_energy (R - 1,), raw;
    residual: largest |dE/d turn| of any step (weights sum to one, lengths in body lengths);
    degree: of the step energy in the displacement (2: linear drag, 1: Coulomb friction).
    """

    status: Status
    poses: Floats
    vertices: Floats
    step_energy: Floats
    residual: float
    steps_per_cycle: int
    degree: int = 2

    def summary(self) -> str:
        """How it ended, how far it went."""
        return f"{self.status.name.lower()}, {len(self.poses)} poses, {self.displacement:.6f} body lengths"

    @property
    def net_motion(self) -> Floats:
        """(x, y, heading) of the last pose relative to the first, in the first body frame, shape (3,)."""
        dx, dy, turn = self.poses[-1] - self.poses[0]
        c, s = np.cos(self.poses[0, 2]), np.sin(self.poses[0, 2])
        return np.array([c * dx + s * dy, c * dy - s * dx, turn])

    @property
    def displacement(self) -> float:
        """Distance of the centroid between first and last row [body lengths]."""
        return float(np.hypot(*self.net_motion[:2]))

    @property
    def forward_displacement(self) -> float:
        """Signed part of the displacement along the mean heading [body lengths]."""
        mean = self.poses[:, 2].mean()
        dx, dy = self.poses[-1, :2] - self.poses[0, :2]
        return float(np.cos(mean) * dx + np.sin(mean) * dy)

    @property
    def heading_change(self) -> float:
        """Turn between first and last row [rad]."""
        return float(self.net_motion[2])

    @property
    def energy_raw(self) -> float:
        """Sum of the step energies; with linear drag it falls as 1 / T for a fixed gait."""
        return float(self.step_energy.sum())

    @property
    def dissipation(self) -> float:
        """T^(degree - 1) times E: normalised dissipation, converges as T grows."""
        return self.steps_per_cycle ** (self.degree - 1) * self.energy_raw
