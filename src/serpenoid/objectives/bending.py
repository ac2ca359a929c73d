"""Inner dissipation of bending: as if every joint had a damper; keeps free gaits from moving joints for nothing.

T sum_t sum_j (alpha_j^{t+1} - alpha_j^t)^2 converges to the integral of |d alpha / dt|^2 over a cycle.
"""

from __future__ import annotations

from typing import Literal

import casadi as ca

from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.term import Term


class Bending(Term):
    """T times the sum of the squared changes of all joint angles [rad^2 per cycle]."""

    kind: Literal["bending"] = "bending"

    def expression(self, of: Criteria) -> ca.SX:
        """Zero for a body that keeps its shape."""
        return of.steps * ca.sumsqr(of.changes)
