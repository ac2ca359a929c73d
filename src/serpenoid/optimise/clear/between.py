"""Where the points of a body are between two rows of its motion: joints turn at constant rates, the frame moves evenly.

    edge direction phi_e = heading + psi_e (linear in time);  point = (x, y) + sum_e lever_e (cos phi_e, sin phi_e)

so the velocity is exact and the acceleration at most sum_e |lever_e| (d phi_e / d time)^2. Time is in steps.
Legend: B motions, T steps, m joints, n edges, I points.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.mechanics.evaluate import evaluate
from serpenoid.model import Model
from serpenoid.objectives.criteria import Gaps
from serpenoid.optimise.step.joint_rows import directions, placement

TOGETHER = 512  # points that are looked at in one call


@dataclass(frozen=True)
class Moments:
    """Points (I) on the body: at `share` [0, 1) of `step`, on `edge` at `place` [0, 1]."""

    step: np.ndarray
    share: Floats
    edge: np.ndarray
    place: Floats


@dataclass(frozen=True)
class Between:
    """Motions of one model: poses (B, T + 1, 3) and realised joint angles (B, T + 1, m) of all rows."""

    model: Model
    poses: Floats
    angles: Floats

    @property
    def steps(self) -> int:
        """T."""
        return self.poses.shape[1] - 1

    @cached_property
    def levers(self) -> Floats:
        """How far vertices are moved by unit edges, shape (n + 1, n): vertices = levers (cos phi, sin phi)."""
        return np.asarray(
            ca.evalf(placement(self.model.structure, ca.MX(ca.DM(self.model.parameters)))).full(), np.float64
        )

    @cached_property
    def phi(self) -> Floats:
        """Directions of all edges in the world, shape (B, T + 1, n)."""
        to_psi, _ = directions(self.model.structure, links=False)
        return np.asarray(self.poses[..., 2:] + self.angles @ to_psi.T)

    @property
    def vertices(self) -> Floats:
        """Where all vertices are in all rows, shape (B, T + 1, n + 1, 2)."""
        unit = np.stack([np.cos(self.phi), np.sin(self.phi)], -1)
        return np.asarray(self.poses[:, :, None, :2] + self.levers @ unit)

    def points(self, at: Moments) -> Floats:
        """Where the points are, shape (B, I, 2)."""
        late, unit = at.share[:, None], self._units(at)
        middle = (1 - late) * self.poses[:, at.step, :2] + late * self.poses[:, at.step + 1, :2]
        return np.asarray(middle + (self._lever(at)[..., None] * unit).sum(-2))

    def velocities(self, at: Moments) -> Floats:
        """Derivatives of `points` by the time in steps, shape (B, I, 2)."""
        turned, unit = self._turned(at), self._units(at)
        across = np.stack([-unit[..., 1], unit[..., 0]], -1)
        moved = self.poses[:, at.step + 1, :2] - self.poses[:, at.step, :2]
        return np.asarray(moved + ((self._lever(at) * turned)[..., None] * across).sum(-2))

    def along(self, at: Moments) -> Floats:
        """Derivatives of `points` by the place on their edge, shape (B, I, 2)."""
        unit = self._units(at)
        return np.asarray(self.model.body.edges[at.edge][:, None] * unit[:, np.arange(len(at.edge)), at.edge])

    def bends(self, at: Moments) -> tuple[Floats, Floats]:
        """Largest second derivatives in a step: by time twice, by time and place, shape (B, I) each."""
        turned = np.abs(self._turned(at))
        ends = np.maximum(np.abs(self.levers[at.edge]), np.abs(self.levers[at.edge + 1]))
        of_edge = turned[:, np.arange(len(at.edge)), at.edge]
        return (ends * turned**2).sum(-1), np.asarray(self.model.body.edges)[at.edge] * of_edge

    def _lever(self, at: Moments) -> Floats:
        place = at.place[:, None]
        return np.asarray((1 - place) * self.levers[at.edge] + place * self.levers[at.edge + 1])

    def _turned(self, at: Moments) -> Floats:
        return np.asarray(self.phi[:, at.step + 1] - self.phi[:, at.step])

    def _units(self, at: Moments) -> Floats:
        late = at.share[:, None]
        phi = (1 - late) * self.phi[:, at.step] + late * self.phi[:, at.step + 1]
        return np.stack([np.cos(phi), np.sin(phi)], -1)


@dataclass(frozen=True)
class GapField:
    """All gaps of a task at single points, with their gradients; `convex` (c): whose tangent planes lie below them."""

    gaps: tuple[Gaps, ...]

    @cached_property
    def _function(self) -> ca.Function:
        """Gaps (c) and gradients (c, 2) of TOGETHER points."""
        point = ca.SX.sym("point", 2)
        value = ca.densify(ca.vertcat(*(gap.of(point) for gap in self.gaps)))
        outputs = [value, ca.densify(ca.jacobian(value, point))]
        return ca.Function("gaps_of_a_point", [point], outputs).map(TOGETHER)

    @cached_property
    def convex(self) -> np.ndarray:
        """Per gap, shape (c,)."""
        one = ca.SX.zeros(2, 1)
        return np.concatenate([np.zeros(0, bool), *(np.full(gap.of(one).numel(), gap.convex) for gap in self.gaps)])

    def at(self, points: Floats) -> tuple[Floats, Floats]:
        """Gaps (I, c) and gradients (I, c, 2) at points (I, 2)."""
        count, c = len(points), self.convex.size
        padded = np.zeros((-(-count // TOGETHER), TOGETHER, 2))
        padded.reshape(-1, 2)[:count] = points
        found = [evaluate(self._function, part) for part in padded]
        value = np.concatenate([np.zeros((0, c)), *(v.T for v, _ in found)])
        slope = np.concatenate([np.zeros((0, 2, c)), *(s.T.reshape(-1, 2, c) for _, s in found)])
        return value[:count], slope[:count].transpose(0, 2, 1)
