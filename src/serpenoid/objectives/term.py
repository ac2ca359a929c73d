"""What a problem file can ask of a gait: terms of the objective, and demands. One kind per file, found by listing."""

from __future__ import annotations

from abc import abstractmethod

import casadi as ca
from pydantic import Field

from serpenoid.files.schema import Record
from serpenoid.objectives.criteria import Criteria


class Term(Record):
    """One term of the objective, times its weight; one entry of `[[task.objectives]]`."""

    kind: str
    weight: float = Field(default=1.0, ge=0, description="factor of this term in the objective")

    @abstractmethod
    def expression(self, of: Criteria) -> ca.SX:
        """The term's value, to be minimised."""


class Demand(Record):
    """One requirement; one entry of `[[task.demands]]`."""

    kind: str

    @abstractmethod
    def require(self, of: Criteria) -> None:
        """Add the requirement to the criteria."""
