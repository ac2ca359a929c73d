"""Closed curves in serpenoid space as Fourier series, with several spatial modes if wanted.

kappa(s, t) = sum over modes of  w1(t) sin(2 pi xi s) + w2(t) cos(2 pi xi s),
w(t) = mean + sum over orders k of  c_k cos(2 pi k t) + s_k sin(2 pi k t),    t in cycles

An ellipse is the case of one mode and order 1.
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

import casadi as ca
import numpy as np
from pydantic import AfterValidator, Field, model_validator

from serpenoid.body import Floats
from serpenoid.gaits.bounds import refuse_unordered
from serpenoid.gaits.ellipse import EllipseGait
from serpenoid.gaits.family import Coordinates, Gait, GaitBounds, GaitFamily, as_rows
from serpenoid.wording import counted

Range = tuple[float, float]


def _each_once(orders: tuple[int, ...]) -> tuple[int, ...]:
    if len(set(orders)) < len(orders):
        raise ValueError("each order may be there once; two of the same are one, of the sum of their coefficients")
    return orders


Orders = Annotated[tuple[Annotated[int, Field(ge=1)], ...], Field(min_length=1), AfterValidator(_each_once)]


def aliased(orders: tuple[int, ...], steps: int) -> str | None:
    """Of an order that rows cannot tell from a lower one: at k = T / 2 its sine is zero in all of them."""
    if 2 * max(orders) < steps:
        return None
    wanted = f"task.steps of more than {2 * max(orders)}, twice the highest"
    return f"`orders` {list(orders)} need {wanted}, got {steps}; leave it out, or raise task.steps"


class FourierBounds(GaitBounds):
    """Where the optimiser may look."""

    family: Literal["fourier"] = "fourier"
    mean: Range = Field(default=(-6.0, 6.0), description="constant part of every w")
    w: Range = Field(default=(-15.0, 15.0), description="every Fourier coefficient of w")
    xi: Range = Field(default=(0.5, 2.5), description="spatial frequency of every mode")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        refuse_unordered(self, "mean", "w", "xi")
        if self.xi[0] <= 0:
            raise ValueError("`xi` must be positive")
        return self


class FourierGait(Gait):
    """Rows of `w`: w1 and w2 of the first mode, then of the next; columns: mean, then cosine and sine of each order."""

    Bounds: ClassVar[type[GaitBounds]] = FourierBounds

    family: Literal["fourier"] = "fourier"
    orders: Orders = (1, 2)
    xi: tuple[Annotated[float, Field(gt=0)], ...] = Field(default=(1.0,), min_length=1, description="one per mode")
    w: tuple[tuple[float, ...], ...] | None = Field(default=None, description="coefficients; default: circle of 6")

    @model_validator(mode="after")
    def _shape(self) -> Self:
        rows, columns = 2 * len(self.xi), 1 + 2 * len(self.orders)
        if self.w is not None and [len(row) for row in self.w] != [columns] * rows:
            raise ValueError(f"`w` needs {rows} rows of {columns} numbers: mean, cosine and sine of every order")
        return self

    @classmethod
    def from_ellipse(cls, gait: EllipseGait, orders: tuple[int, ...] = (1, 2), modes: int = 1) -> FourierGait:
        """The same gait as a member of a larger family; further modes are silent and of other wavelengths."""
        w = np.zeros((2 * modes, 1 + 2 * len(orders)))
        c, s, first = np.cos(gait.theta), np.sin(gait.theta), 1 + 2 * orders.index(1)
        w[:2, 0] = gait.x_c, gait.y_c
        w[:2, first], w[:2, first + 1] = gait.a * np.array([c, s]), gait.a * gait.sigma * np.array([-s, c])
        xi = tuple(gait.xi * (1 + 0.5 * mode) for mode in range(modes))
        return cls(orders=orders, xi=xi, w=as_rows(w))

    def of(self, joints: int, rows: int, bounds: GaitBounds | None = None, closed: bool = True) -> FourierFamily:
        """Series of the same orders and number of modes."""
        return FourierFamily(self, joints, rows, bounds or FourierBounds(), closed)

    def misfit(self, joints: int, steps: int) -> str | None:
        """Orders that the rows do not show."""
        return aliased(self.orders, steps)

    def curve(self, phases: Floats) -> Floats | None:
        """(w1, w2) of a gait with one mode."""
        if len(self.xi) > 1:
            return None
        family = self.of(1, 1)
        return np.asarray(waves(np.asarray(phases), self.orders) @ family.start()[1:].reshape(2, -1).T, np.float64)

    @property
    def words(self) -> str:
        """One line for people."""
        return (
            f"{counted(len(self.xi), 'mode')}, orders {list(self.orders)}, xi {', '.join(f'{x:.4f}' for x in self.xi)}"
        )


def waves(phases: Floats, orders: tuple[int, ...]) -> Floats:
    """1, cos and sin of every order at phases (n,): shape (n, 1 + 2 K)."""
    angles = 2 * np.pi * phases[:, None] * np.array(orders)
    pairs = np.stack([np.cos(angles), np.sin(angles)], -1).reshape(len(phases), -1)
    return np.hstack([np.ones((len(phases), 1)), pairs])


class FourierFamily(GaitFamily):
    """Parameters: xi of every mode, then the rows of w."""

    coordinates: ClassVar[Coordinates] = "serpenoid"
    linear: ClassVar[bool] = False

    @property
    def _gait(self) -> FourierGait:
        return self.like if isinstance(self.like, FourierGait) else FourierGait()

    @property
    def modes(self) -> int:
        return len(self._gait.xi)

    @property
    def names(self) -> tuple[str, ...]:
        tags = ["mean", *(f"{part}{k}" for k in self._gait.orders for part in ("cos", "sin"))]
        rows = [f"w{i}_{mode + 1}" for mode in range(self.modes) for i in (1, 2)]
        return (*(f"xi_{mode + 1}" for mode in range(self.modes)), *(f"{row}_{tag}" for row in rows for tag in tags))

    @property
    def units(self) -> tuple[str, ...]:
        return ("waves",) * self.modes + ("rad",) * (self.size - self.modes)

    @property
    def limits(self) -> tuple[Floats, Floats]:
        b = self.bounds if isinstance(self.bounds, FourierBounds) else FourierBounds()
        row = [b.mean, *[b.w] * (2 * len(self._gait.orders))]
        pairs = np.array([*[b.xi] * self.modes, *row * (2 * self.modes)])
        return pairs[:, 0], pairs[:, 1]

    @property
    def widths(self) -> Floats:
        return np.where(np.arange(self.size) < self.modes, 0.02, 0.1)

    @property
    def harmonic(self) -> bool:
        return self._gait.orders == (1,)

    def at(self, p: ca.SX, data: ca.SX) -> ca.SX:
        """(w1, w2, xi) of every mode."""
        angles = [2 * ca.pi * k * data[0] for k in self._gait.orders]
        basis = ca.vertcat(1, *(part for a in angles for part in (ca.cos(a), ca.sin(a))))
        w = ca.reshape(p[self.modes :], basis.numel(), 2 * self.modes).T @ basis
        return ca.vertcat(*(ca.vertcat(w[2 * i : 2 * i + 2], p[i]) for i in range(self.modes)))

    def start(self) -> Floats:
        gait = self._gait
        w = gait.w
        if w is None:
            orders = gait.orders
            first = orders if 1 in orders else (1, *orders)
            w = FourierGait.from_ellipse(EllipseGait(xi=gait.xi[0]), first, self.modes).w
            w = w if 1 in orders else tuple((row[0], *row[3:]) for row in w or ())
        return np.concatenate([gait.xi, np.array(w).ravel()])

    def sample(self, rng: np.random.Generator) -> Floats:
        """Coefficients fall with their order."""
        lower, upper = self.limits
        fall = np.array([1.0, *np.repeat(1 / np.array(self._gait.orders), 2)])
        scale = np.concatenate([np.ones(self.modes), np.tile(fall, 2 * self.modes)])
        middle = np.where(np.arange(self.size) < self.modes, 0.0, (lower + upper) / 2)
        return np.clip(middle + scale * (rng.uniform(lower, upper) - middle), lower, upper)

    def scaled(self, p: Floats, factor: float) -> Floats:
        return np.concatenate([p[: self.modes], factor * p[self.modes :]])

    @property
    def steady(self) -> Floats:
        """The mean of every w."""
        return np.eye(self.size)[self.modes :: 1 + 2 * len(self._gait.orders)]

    def gait(self, p: Floats) -> FourierGait:
        w = p[self.modes :].reshape(2 * self.modes, -1)
        xi = tuple(float(x) for x in p[: self.modes])
        return FourierGait(orders=self._gait.orders, xi=xi, w=as_rows(w))
