"""A dissipation law: what a slip of an element costs.

    q = |dp|^2 + (r - 1)/2 (<dp, T>^2 + <dp, T'>^2),  r = eps^(2 / degree)     squared slip, T, T' before and after
    E = sum_k w_k potential(q_k),   force = -w multiplier(q) D dp,   multiplier = 2 d potential / dq

q is the same quadratic form for every law, so a law is a function of one number, and its wrench is the linear one times
a multiplier that both ends of the step share. eps is lengthwise over sideways force, of slips of one size.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

Quantity = Any  # a number, an array or a symbol of CasADi's
OfSlip = Callable[[Quantity, Quantity], Quantity]


@dataclass(frozen=True)
class Rival:
    """When a diagnosis asks whether a law does better than another, `of`, that it has fitted.

    title: what the law is called there; needs: what must be there for it to be a question (see `Body.parts`).
    """

    of: Law
    title: str
    needs: frozenset[str] = frozenset()


@dataclass(frozen=True, eq=False)
class Law:
    """potential, multiplier: functions of squared slip and softening length.

    degree: of the potential in the displacement. The sum over a cycle of T steps, times T^(degree - 1), converges.
    words: what resists, in sentences; title: what the law is called beside others. softened: whether the potential
    depends on the softening length. softer: the linear law, with the ratio form_ratio(eps), that it becomes where it is
    softened beyond any slip, if its optima are found from there; None: they are found without. rival: see `Rival`;
    None: a diagnosis knows it where a file says so, and does not ask for it.
    """

    name: str
    words: str
    title: str
    degree: int
    potential: OfSlip
    multiplier: OfSlip
    softened: bool = False
    softer: Law | None = None
    rival: Rival | None = None

    def form_ratio(self, eps: Quantity) -> Quantity:
        """r of the squared slip."""
        return eps ** (2 / self.degree)

    @property
    def linear(self) -> bool:
        """Whether forces are proportional to slips: a step's energy is quadratic, eps the drag of a straight body."""
        return self.degree == 2 and not self.softened
