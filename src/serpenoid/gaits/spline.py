"""Every joint a uniform cubic B-spline in time: twice differentiable, and a row depends on four control points only.

alpha(t) = sum_{i=0..3} b_i(f) P_{k+i-1},   k = floor(u), f = u - k,   u = P t for a closed gait of P control points
"""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar, Literal, Self

import casadi as ca
import numpy as np
from pydantic import Field, model_validator

from serpenoid.body import Floats
from serpenoid.gaits.bounds import AngleBounds, GaitBounds
from serpenoid.gaits.family import AngleFamily, Gait, as_rows
from serpenoid.wording import counted


class SplineBounds(AngleBounds):
    """Where the optimiser may look."""

    family: Literal["spline"] = "spline"


class SplineGait(Gait):
    """`points` control points per joint; `angles`: their values, one row of m joint angles per point [rad]."""

    Bounds: ClassVar[type[GaitBounds]] = SplineBounds

    family: Literal["spline"] = "spline"
    points: int = Field(default=10, ge=5, description="control points of each joint")
    angles: tuple[tuple[float, ...], ...] | None = Field(default=None, description="their values; default: straight")

    @model_validator(mode="after")
    def _shape(self) -> Self:
        if self.angles is not None and len(self.angles) != self.points:
            raise ValueError(f"`angles` needs {self.points} rows, one per control point, got {len(self.angles)}")
        return self

    def misfit(self, joints: int, steps: int) -> str | None:
        """Control points of other joints."""
        widths = sorted({len(row) for row in self.angles or ()} - {joints})
        return (
            f"`angles` needs {counted(joints, 'number')} in every row, one per joint, got {widths[0]}"
            if widths
            else None
        )

    def of(self, joints: int, rows: int, bounds: GaitBounds | None = None, closed: bool = True) -> SplineFamily:
        """Splines with as many control points."""
        return SplineFamily(self, joints, rows, bounds or SplineBounds(), closed)

    @classmethod
    def from_table(cls, table: Floats, points: int, closed: bool = True) -> SplineGait:
        """The spline nearest to a joint table (R, m) in mean square."""
        family = cls(points=points).of(table.shape[1], len(table), closed=closed)
        where = family.indices[:, :: table.shape[1]] // table.shape[1]
        basis = np.zeros((len(table), points))
        np.add.at(basis, (np.arange(len(table))[:, None], where), family.data)
        rows = np.linalg.lstsq(basis, table, rcond=None)[0]
        return cls(points=points, angles=as_rows(rows))

    @property
    def words(self) -> str:
        """One line for people."""
        return f"cubic splines with {self.points} control points per joint"


class SplineFamily(AngleFamily):
    """Parameters: control points, point by point; a row depends on 4 m of them."""

    @property
    def points(self) -> int:
        return self.like.points if isinstance(self.like, SplineGait) else 10

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(f"joint_{j + 1}_point_{i + 1}" for i in range(self.points) for j in range(self.joints))

    @cached_property
    def _places(self) -> tuple[np.ndarray, Floats]:
        """First of the four control points of every row, and the place within its span."""
        segments = self.points if self.closed else self.points - 3
        u = segments * np.arange(self.rows) / (self.rows - (not self.closed))
        first = np.minimum(np.floor(u), segments - 1).astype(int)
        return first, u - first

    @cached_property
    def data(self) -> Floats:
        """The four weights of every row."""
        f = self._places[1]
        weights = [(1 - f) ** 3, 3 * f**3 - 6 * f**2 + 4, -3 * f**3 + 3 * f**2 + 3 * f + 1, f**3]
        return np.stack(weights, -1) / 6

    @cached_property
    def indices(self) -> np.ndarray:
        point = (self._places[0][:, None] + np.arange(4)) % self.points
        return np.asarray((point[..., None] * self.joints + np.arange(self.joints)).reshape(self.rows, -1))

    def at(self, p: ca.SX, data: ca.SX) -> ca.SX:
        """Weighted sum of four control points."""
        return ca.reshape(p, self.joints, 4) @ data

    def start(self) -> Floats:
        angles = self.like.angles if isinstance(self.like, SplineGait) else None
        return np.zeros(self.size) if angles is None else np.array(angles).ravel()

    def sample(self, rng: np.random.Generator) -> Floats:
        """Waves through the control points."""
        phase = 2 * np.pi * np.arange(self.points)[:, None] / self.points
        shift = rng.uniform(0, 2 * np.pi, self.joints)
        table = 0.15 * rng.normal(size=self.joints) + 0.4 * rng.normal(size=self.joints) * np.cos(phase + shift)
        return np.clip(table.ravel(), *self.limits)

    def moves(self, p: Floats) -> bool:
        """Not where all control points are the same."""
        return bool(np.ptp(p.reshape(self.points, self.joints), axis=0).any())

    @property
    def steady(self) -> Floats:
        """All control points of a joint."""
        return np.tile(np.eye(self.joints), self.points)

    def gait(self, p: Floats) -> SplineGait:
        return SplineGait(points=self.points, angles=as_rows(p.reshape(self.points, self.joints)))
