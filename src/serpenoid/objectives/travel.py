"""Go a given way: the centroid's distance over the cycle [body lengths] within limits."""

from __future__ import annotations

from typing import Literal, Self

import numpy as np
from pydantic import Field, model_validator

from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.term import FAR, Ask, Demand, Played, Rows, told


class Travel(Demand):
    """least <= displacement <= most; equal ends prescribe it."""

    kind: Literal["travel"] = "travel"
    least: float = Field(ge=0, description="body lengths per cycle")
    most: float = Field(default=100.0, gt=0, le=FAR, description="body lengths per cycle")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.least > self.most:
            raise ValueError("`least` must not exceed `most`")
        return self

    def require(self, of: Criteria) -> None:
        """On the squared distance, which is smooth at a gait that does not move."""
        squared = of.poses[0, -1] ** 2 + of.poses[1, -1] ** 2
        of.subject_to(squared, self.least**2, self.most**2)

    def asks(self, rows: Rows) -> list[Ask]:
        """The displacement itself."""
        return [Ask("displacement", self.least, self.most)]

    def outcome(self, played: Played) -> str:
        """How far it goes beyond the ends."""
        way = float(np.hypot(*played.poses[-1, :2]))
        beyond = max(self.least - way, way - self.most, 0.0)
        ends = f"{self.least:g}" if self.least == self.most else f"{self.least:g} to {self.most:g}"
        return told(f"displacement {ends}", beyond)
