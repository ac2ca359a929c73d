"""Every joint a Fourier series: alpha_j(t) = mean_j + sum over orders k of c cos(2 pi k t) + s sin(2 pi k t)."""

from __future__ import annotations

from typing import ClassVar, Literal, Self

import casadi as ca
import numpy as np
from pydantic import Field, model_validator

from serpenoid.body import Floats
from serpenoid.gaits.bounds import AngleBounds, GaitBounds, refuse_unordered
from serpenoid.gaits.family import AngleFamily, Gait, as_rows
from serpenoid.gaits.fourier import Orders, aliased, waves
from serpenoid.wording import counted


class JointSeriesBounds(AngleBounds):
    """Where the optimiser may look."""

    family: Literal["fourier-joints"] = "fourier-joints"
    angle: tuple[float, float] = Field(default=(-np.pi, np.pi), description="every coefficient [rad], to either side")
    mean: tuple[float, float] | None = Field(default=None, description="mean of every joint [rad]; default: as `angle`")

    @model_validator(mode="after")
    def _of_either_sign(self) -> Self:
        if self.angle[0] != -self.angle[1]:
            raise ValueError(
                "`angle` bounds the coefficients of cosines and sines, not joint angles: [-x, x]; for joints that bend "
                "to one side farther than to the other give [body] joint_limit_deg = [lower, upper] in degrees"
            )
        return self

    @model_validator(mode="after")
    def _ordered_mean(self) -> Self:
        refuse_unordered(self, "mean")
        return self


class JointSeriesGait(Gait):
    """Rows of `angles`: joints from the tail; columns: mean, then cosine and sine of each order [rad]."""

    Bounds: ClassVar[type[GaitBounds]] = JointSeriesBounds

    family: Literal["fourier-joints"] = "fourier-joints"
    orders: Orders = (1, 2)
    angles: tuple[tuple[float, ...], ...] | None = Field(default=None, description="coefficients; default: straight")

    @model_validator(mode="after")
    def _shape(self) -> Self:
        columns = 1 + 2 * len(self.orders)
        if self.angles is not None and any(len(row) != columns for row in self.angles):
            raise ValueError(f"`angles` needs rows of {columns} numbers: mean, cosine and sine of every order")
        return self

    def misfit(self, joints: int, steps: int) -> str | None:
        """Rows for other joints, orders that the rows of the table do not show."""
        if self.angles is not None and len(self.angles) != joints:
            return f"`angles` needs {counted(joints, 'row')}, one per joint, got {len(self.angles)}"
        return aliased(self.orders, steps)

    def of(self, joints: int, rows: int, bounds: GaitBounds | None = None, closed: bool = True) -> JointSeriesFamily:
        """Series of the same orders."""
        return JointSeriesFamily(self, joints, rows, bounds or JointSeriesBounds(), closed)

    @classmethod
    def from_table(cls, table: Floats, orders: tuple[int, ...]) -> JointSeriesGait:
        """The series nearest to a joint table (T, m) in mean square."""
        basis = waves(np.arange(len(table)) / len(table), orders)
        rows = np.linalg.lstsq(basis, table, rcond=None)[0].T
        return cls(orders=orders, angles=as_rows(rows))

    @property
    def words(self) -> str:
        """One line for people."""
        return f"a Fourier series of orders {list(self.orders)} per joint"


class JointSeriesFamily(AngleFamily):
    """Parameters: the rows of `angles`; every row of the table depends on all of them."""

    @property
    def orders(self) -> tuple[int, ...]:
        return self.like.orders if isinstance(self.like, JointSeriesGait) else (1, 2)

    @property
    def names(self) -> tuple[str, ...]:
        tags = ["mean", *(f"{part}{k}" for k in self.orders for part in ("cos", "sin"))]
        return tuple(f"joint_{j + 1}_{tag}" for j in range(self.joints) for tag in tags)

    @property
    def limits(self) -> tuple[Floats, Floats]:
        bounds = self.bounds if isinstance(self.bounds, JointSeriesBounds) else JointSeriesBounds()
        pairs = np.tile(bounds.angle, (self.joints, 1 + 2 * len(self.orders), 1))
        pairs[:, 0] = bounds.mean or bounds.angle
        return pairs[..., 0].ravel(), pairs[..., 1].ravel()

    @property
    def harmonic(self) -> bool:
        return self.orders == (1,)

    def at(self, p: ca.SX, data: ca.SX) -> ca.SX:
        """Joint angles at the phase data[0]."""
        angles = [2 * ca.pi * k * data[0] for k in self.orders]
        basis = ca.vertcat(1, *(part for a in angles for part in (ca.cos(a), ca.sin(a))))
        return ca.reshape(p, basis.numel(), self.joints).T @ basis

    def start(self) -> Floats:
        angles = self.like.angles if isinstance(self.like, JointSeriesGait) else None
        return np.zeros(self.size) if angles is None else np.array(angles).ravel()

    def sample(self, rng: np.random.Generator) -> Floats:
        """Coefficients of some tenths of a radian that fall with their order."""
        fall = np.array([0.15, *np.repeat(0.3 / np.array(self.orders), 2)])
        return np.clip(np.tile(fall, self.joints) * rng.normal(size=self.size), *self.limits)

    def moves(self, p: Floats) -> bool:
        """Not where only the means are there."""
        return bool(p.reshape(self.joints, -1)[:, 1:].any())

    @property
    def steady(self) -> Floats:
        """The mean of every joint."""
        return np.eye(self.size)[:: 1 + 2 * len(self.orders)]

    def gait(self, p: Floats) -> JointSeriesGait:
        return JointSeriesGait(orders=self.orders, angles=as_rows(p.reshape(self.joints, -1)))
