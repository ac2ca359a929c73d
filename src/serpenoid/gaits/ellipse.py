"""Elliptical gaits in the serpenoid shape space.

(w1, w2)(t) = R_theta (a cos 2 pi t, a sigma sin 2 pi t) + (x_c, y_c), t in cycles     (Even et al., Sec. III-A)
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from serpenoid.body import Floats
from serpenoid.schema import Record


class EllipseGait(Record):
    """An ellipse with six parameters; kappa and therefore a, x_c, y_c are per body length."""

    NAMES: ClassVar[tuple[str, ...]] = ("sigma", "x_c", "y_c", "theta", "a", "xi")

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

    @classmethod
    def from_parameters(cls, q: Floats) -> EllipseGait:
        """The gait with parameters `q`, theta wrapped to (-pi, pi]."""
        values = dict(zip(cls.NAMES, (float(x) for x in q), strict=True))
        values["theta"] = float(-np.remainder(np.pi - values["theta"], 2 * np.pi) + np.pi)
        values["sigma"] = float(np.clip(values["sigma"], -1, 1))
        values["a"] = max(values["a"], 0.0)
        return cls.model_validate(values)

    def curve(self, phases: Floats) -> Floats:
        """(w1, w2) at `phases` [cycles]: shape (n,) -> (n, 2)."""
        t = 2 * np.pi * np.asarray(phases)
        x, y = self.a * np.cos(t), self.a * self.sigma * np.sin(t)
        c, s = np.cos(self.theta), np.sin(self.theta)
        return np.stack([c * x - s * y + self.x_c, s * x + c * y + self.y_c], -1)
