"""At least dissipation: the work against the medium, T * E (the weight `c` of the task does the same)."""

from __future__ import annotations

from typing import Literal

import casadi as ca

from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.term import Term


class Effort(Term):
    """The normalised dissipation T * E of the cycle."""

    kind: Literal["effort"] = "effort"

    def expression(self, of: Criteria) -> ca.SX:
        """T * E."""
        return of.dissipation
