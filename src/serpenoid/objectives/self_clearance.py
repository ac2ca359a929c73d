"""Keep off itself: parts of the body that are not neighbours stay apart, at every time (`optimise/clear/apart.py`)."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from serpenoid.body import Floats
from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.term import Demand


class SelfClearance(Demand):
    """The distance between any two edges with `between` or more edges between them."""

    kind: Literal["self"] = "self"
    flat: ClassVar[str] = "a distance from itself is proven for bodies that lie flat"
    distance: Annotated[float, Field(gt=0, le=0.5, description="to keep: the body's width, say [body lengths]")]
    between: int = Field(default=1, ge=1, description="edges with fewer between them are neighbours")

    def most(self, edges: Floats) -> float:
        """The largest distance that any shape keeps: as far as the edges between reach, of lengths `edges` (N - 1)."""
        return float(np.convolve(edges[1:-1], np.ones(self.between), "valid").min())

    def require(self, of: Criteria) -> None:
        """Nothing at once: pairs are asked for as they come near (`optimise/clear/apart.py`)."""
