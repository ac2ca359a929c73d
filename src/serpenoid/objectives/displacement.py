"""As far as possible: minus the distance of the centroid over the cycle [body lengths]."""

from __future__ import annotations

from typing import Literal

import casadi as ca

from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.term import Term


class Displacement(Term):
    """-|(x, y) of the last pose|."""

    kind: Literal["displacement"] = "displacement"

    def expression(self, of: Criteria) -> ca.SX:
        """Negative: farther is better."""
        return -of.displacement
