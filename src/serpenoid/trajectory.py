"""A simulated (or re-simulated) motion: poses, vertices and step energies, in body lengths and cycles.

Legend: R rows (T + 1 for one cycle of T steps), N vertices.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from serpenoid import group
from serpenoid.body import Floats
from serpenoid.shown import Shown
from serpenoid.status import Status
from serpenoid.wording import warned

STILL = 1e-4  # body lengths: the tremble that an optimiser leaves of a gait that stands


@dataclass(frozen=True, repr=False, eq=False)
class Trajectory(Shown):
    """Motion of the body frame (weighted centroid, mean edge angle) and of every vertex.

    poses (R, 3): x, y [body lengths], heading [rad]; vertices (R, N, 2) [body lengths]; step_energy (R - 1,), raw;
    residual: largest |dE/d turn| of any step (weights sum to one, lengths in body lengths);
    degree: of the step energy in the displacement (2: linear drag); odd_units: what of the shapes looks to be told in
    another unit, as sentences.
    """

    status: Status
    poses: Floats
    vertices: Floats
    step_energy: Floats
    residual: float
    steps_per_cycle: int
    degree: int = 2
    odd_units: tuple[str, ...] = ()

    def summary(self) -> str:
        """How it ended, how far it went; what looks to be told in another unit."""
        went = f"{self.status.name.lower()}, {len(self.poses)} poses, {self.displacement:.6f} body lengths"
        return warned(went, self.odd_units)

    @property
    def net_motion(self) -> Floats:
        """(x, y, heading) of the last pose relative to the first, in the first body frame, shape (3,)."""
        dx, dy, turn = (self.poses[-1] - self.poses[0])[:3]
        c, s = np.cos(self.poses[0, 2]), np.sin(self.poses[0, 2])
        return np.array([c * dx + s * dy, c * dy - s * dx, turn])

    @property
    def displacement(self) -> float:
        """Distance of the centroid between first and last row [body lengths]."""
        return float(np.hypot(*self.net_motion[:2]))

    @property
    def stands_still(self) -> bool:
        """Whether no point of the body moves."""
        return bool(np.abs(self.vertices - self.vertices[0]).max() < STILL)

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
        return self.dissipation_of(len(self.step_energy))

    def dissipation_of(self, steps: int) -> float:
        """The same of the first steps alone."""
        return float(self.steps_per_cycle ** (self.degree - 1) * self.step_energy[:steps].sum())


RESTING = 0.5  # of the contact: what rests more than this carries the body


@dataclass(frozen=True, repr=False, eq=False)
class LiftedTrajectory(Trajectory):
    """A motion in space: poses (R, 6), (z, pitch, roll) after (x, y, heading); vertices (R, N, 3).

    contact (R, N): what each vertex carries over its own weight; weights (N).
    """

    contact: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    weights: Floats = field(default_factory=lambda: np.zeros(0))

    @property
    def rotations(self) -> Floats:
        """Of all rows, (R, 3, 3)."""
        return group.spatial_rotation(self.poses)

    @property
    def tilt(self) -> float:
        """Largest angle between the body's plane and the floor [rad]."""
        return float(np.arccos(np.clip(self.rotations[:, 2, 2], -1, 1)).max())

    @property
    def sideways_deg(self) -> float:
        """Angle between the way and the body's mean axis, 0 to 90 [degrees]: a sidewinder's is large."""
        axes, way = self.rotations[:-1, :2, 0].sum(0), self.poses[-1, :2] - self.poses[0, :2]
        cosine = abs(axes @ way) / max(float(np.linalg.norm(axes) * np.linalg.norm(way)), 1e-300)
        return float(np.rad2deg(np.arccos(np.clip(cosine, 0, 1))))

    @property
    def standing(self) -> float:
        """Share of the rows in which the centre of mass is over the hull of what rests: gravity alone holds it."""
        held = 0
        for points, shares in zip(self.vertices[:, :, :2], self.contact, strict=True):
            resting = points[shares * self.weights > RESTING * (shares * self.weights).max()]
            held += _inside(resting, self.weights @ points)
        return held / len(self.vertices)


def floor_lines(motion: Trajectory) -> list[str]:
    """A line for a summary; none for a body that lies flat."""
    if not isinstance(motion, LiftedTrajectory) or not motion.status.ok:
        return []
    return [f"on the floor      {floor_words(motion.sideways_deg, motion.tilt, motion.standing)}"]


def floor_words(sideways_deg: float, tilt: float, standing: float) -> str:
    """One line of a lifted body: its way, how flat it lies [rad], and whether gravity holds it."""
    return (
        f"{sideways_deg:.0f} degrees off the body's axis, tilted by {tilt:.4f} rad at most; what rests holds the "
        f"centre of mass in {100 * standing:.0f} % of the rows"
    )


def _inside(points: Floats, place: Floats) -> bool:
    """Whether a place is in the hull of points: there is no direction that all of them lie away in."""
    angles = np.sort(np.arctan2(*(points - place).T[::-1]))
    gaps = np.diff(np.append(angles, angles[0] + 2 * np.pi))
    return bool(gaps.max() < np.pi)
