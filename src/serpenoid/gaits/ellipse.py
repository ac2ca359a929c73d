"""Elliptical gaits in the serpenoid shape space.

(w1, w2)(t) = R_theta (a cos 2 pi t, a sigma sin 2 pi t) + (x_c, y_c), t in cycles     (Even et al., Sec. III-A)
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

import casadi as ca
import numpy as np
from pydantic import Field, model_validator

from serpenoid.body import Floats
from serpenoid.gaits.bounds import refuse_unordered
from serpenoid.gaits.family import Coordinates, Gait, GaitBounds, GaitFamily

Range = tuple[float, float]
NAMES = ("sigma", "x_c", "y_c", "theta", "a", "xi")
FREE_ANGLE = (-np.pi, np.pi)


class EllipseBounds(GaitBounds):
    """Where the optimiser may look. Equal ends fix a parameter; `theta` unset is free."""

    family: Literal["ellipse"] = "ellipse"
    sigma: Range = (0.0, 1.0)
    x_c: Range = (-6.0, 6.0)
    y_c: Range = (-6.0, 6.0)
    theta: Range | None = None
    a: Range = (0.0, 15.0)
    xi: Range = (0.5, 2.5)

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        refuse_unordered(self, *NAMES)
        if self.sigma[0] < -1 or self.sigma[1] > 1:
            raise ValueError("`sigma` must lie in [-1, 1]")
        if self.a[0] < 0 or self.xi[0] <= 0:
            raise ValueError("`a` must not be negative, and `xi` must be positive")
        return self


class EllipseGait(Gait):
    """An ellipse with six parameters; kappa and therefore a, x_c, y_c are per body length."""

    NAMES: ClassVar[tuple[str, ...]] = NAMES
    Bounds: ClassVar[type[GaitBounds]] = EllipseBounds

    family: Literal["ellipse"] = "ellipse"
    sigma: Annotated[float, Field(ge=-1, le=1, description="flatness; negative runs the wave backwards")] = 1.0
    x_c: float = Field(default=0.0, description="centre, first coordinate")
    y_c: float = Field(default=0.0, description="centre, second coordinate")
    theta: float = Field(default=0.0, description="rotation of the ellipse [rad]")
    a: Annotated[float, Field(ge=0, description="larger half axis")] = 6.0
    xi: Annotated[float, Field(gt=0, description="spatial frequency, waves per body length")] = 1.0

    @property
    def parameters(self) -> Floats:
        """(sigma, x_c, y_c, theta, a, xi), shape (6,)."""
        return np.array([getattr(self, name) for name in self.NAMES])

    @property
    def rotations(self) -> dict[str, float]:
        """Of the ellipse."""
        return {"theta": self.theta}

    @classmethod
    def from_parameters(cls, q: Floats) -> EllipseGait:
        """The gait with parameters `q`, theta wrapped to (-pi, pi]."""
        values = dict(zip(cls.NAMES, (float(x) for x in q), strict=True))
        values["theta"] = float(-np.remainder(np.pi - values["theta"], 2 * np.pi) + np.pi)
        values["sigma"] = float(np.clip(values["sigma"], -1, 1))
        values["a"] = max(values["a"], 0.0)
        return cls.model_validate(values)

    def of(self, joints: int, rows: int, bounds: GaitBounds | None = None, closed: bool = True) -> EllipseFamily:
        """Ellipses for a table of `rows` rows."""
        return EllipseFamily(self, joints, rows, bounds or EllipseBounds(), closed)

    def curve(self, phases: Floats) -> Floats:
        """(w1, w2) at `phases` [cycles]: shape (n,) -> (n, 2)."""
        t = 2 * np.pi * np.asarray(phases)
        x, y = self.a * np.cos(t), self.a * self.sigma * np.sin(t)
        c, s = np.cos(self.theta), np.sin(self.theta)
        return np.stack([c * x - s * y + self.x_c, s * x + c * y + self.y_c], -1)


class EllipseFamily(GaitFamily):
    """Every row depends on all six parameters and its phase."""

    coordinates: ClassVar[Coordinates] = "serpenoid"
    linear: ClassVar[bool] = False

    @property
    def names(self) -> tuple[str, ...]:
        return NAMES

    @property
    def units(self) -> tuple[str, ...]:
        return ("1", "rad", "rad", "rad", "rad", "waves")

    @property
    def limits(self) -> tuple[Floats, Floats]:
        pairs = np.array([getattr(self.bounds, name) or (-np.inf, np.inf) for name in NAMES], float)
        return pairs[:, 0], pairs[:, 1]

    def ended_at(self, name: str, end: float) -> str | None:
        """The flattest and the roundest ellipse, and the smallest, are no choice of the file."""
        return None if (name, abs(end)) in (("sigma", 1.0), ("a", 0.0)) else name

    @property
    def widths(self) -> Floats:
        return np.array([0.02, 0.1, 0.1, 0.02, 0.1, 0.02])

    @property
    def harmonic(self) -> bool:
        return True

    def at(self, p: ca.SX, data: ca.SX) -> ca.SX:
        """(w1, w2, xi) at the phase data[0]."""
        sigma, x_c, y_c, theta, a, xi = ca.vertsplit(p)
        x, y = a * ca.cos(2 * ca.pi * data[0]), a * sigma * ca.sin(2 * ca.pi * data[0])
        w1 = ca.cos(theta) * x - ca.sin(theta) * y + x_c
        w2 = ca.sin(theta) * x + ca.cos(theta) * y + y_c
        return ca.vertcat(w1, w2, xi)

    def start(self) -> Floats:
        return self.like.parameters if isinstance(self.like, EllipseGait) else EllipseGait().parameters

    def sample(self, rng: np.random.Generator) -> Floats:
        lower, upper = self.limits
        lower = np.where(np.isfinite(lower), lower, FREE_ANGLE[0])
        upper = np.where(np.isfinite(upper), upper, FREE_ANGLE[1])
        return rng.uniform(lower, upper)

    def scaled(self, p: Floats, factor: float) -> Floats:
        return p * np.where(np.isin(NAMES, ("x_c", "y_c", "a")), factor, 1.0)

    @property
    def steady(self) -> Floats:
        """The centre."""
        return np.eye(self.size)[1:3]

    def gait(self, p: Floats) -> EllipseGait:
        return EllipseGait.from_parameters(p)

    def opened(self, p: Floats) -> Floats:
        """An ellipse that is neither a line nor a point of the bounds: sigma in the middle."""
        lower, upper = self.limits
        changed = p.copy()
        changed[0] = (lower[0] + upper[0]) / 2
        return changed
