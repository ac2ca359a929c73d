"""A dissipation law: what a slip of an element costs.

    q = |dp|^2 + (r - 1)/2 (<dp, T>^2 + <dp, T'>^2),  r = form_ratio(eps)      squared slip, T, T' before and after
    E = sum_k w_k potential(q_k),   force = -w multiplier(q) D dp,   multiplier = 2 d potential / dq

q is the same quadratic form for every law, so a law is a function of one number, and its wrench is the linear one times
a multiplier that both ends of the step share.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca

OfSlip = Callable[[ca.SX, ca.SX], ca.SX]


@dataclass(frozen=True, eq=False)
class Law:
    """potential, multiplier: functions of squared slip and softening length; form_ratio: eps -> r of the squared slip.

    degree: of the potential in the displacement. The sum over a cycle of T steps, times T^(degree - 1), converges.
    """

    name: str
    degree: int
    potential: OfSlip
    multiplier: OfSlip
    form_ratio: Callable[[ca.SX], ca.SX]
