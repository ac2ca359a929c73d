"""At least cost of transport: what a way costs in idle energy and in work against the medium, by length."""

from __future__ import annotations

from typing import Literal

import casadi as ca
from pydantic import Field

from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.term import Term


class Transport(Term):
    """(idle + T * E) / |(x, y) of the last pose|; set the task's `c` to 0 beside it."""

    kind: Literal["transport"] = "transport"
    idle: float = Field(gt=0, description="idle energy per cycle, in units of T * E; without it, not moving is best")

    def expression(self, of: Criteria) -> ca.SX:
        """Normalised cost of transport, as in `performance.normalised_cost_of_transport`."""
        return (self.idle + of.dissipation) / of.displacement
