"""As efficient as possible: the work to pull the straight body as far in a cycle, over the work done.

Pulling costs eps * displacement^2 in units of the work 2 T E (total weight 1, one cycle per unit of time): the
efficiency is eps * displacement^2 / (2 T E) (Lighthill 1976; Becker, Koehler & Stone 2003).
"""

from __future__ import annotations

from typing import Literal

import casadi as ca

from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.term import Term


class Efficiency(Term):
    """-displacement^2 / (2 T E): minus Lighthill's efficiency over eps; set the task's `c` to 0 beside it.

    Cases of a robust gait with other eps are compared as they stand here, without their eps.
    """

    kind: Literal["efficiency"] = "efficiency"

    def expression(self, of: Criteria) -> ca.SX:
        """Negative: more is better."""
        return -ca.sumsqr(of.poses[:2, -1]) / (2 * of.dissipation)
