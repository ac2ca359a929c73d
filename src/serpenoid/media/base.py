"""A dissipation law: what a slip of an element costs.

    a = (<dp, T>^2 + <dp, T'>^2) / 2,   n = |dp|^2 - a      squared slip along and across; T, T' before and after
    E = sum_k w_k potential(n + r a),   r = eps^(2 / degree)            one slip of both parts (`slip` = "weighed")
    E = sum_k w_k (potential(n) + r potential(a)),   r = eps            each part by itself ("parts")
    force = -w (m_n <dp, N> N + r m_a <dp, T> T),   multipliers m = 2 d potential

A law is a function of one number, and its wrench is the linear one times multipliers that both ends of the step share;
of one slip both are the same. eps is lengthwise over sideways force, of slips of one size.

    m_n = m_a = multiplier(n + a),   r = eps                            the plain slip, force as of drag ("plain")

has no potential: its cost is the work over the degree, and its wrench no slope of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

Quantity = Any  # a number, an array or a symbol of CasADi's
Slip = Literal["weighed", "parts", "plain"]
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
    depends on the softening length. slip: of what it is a function. softer: the linear law, with the ratio
    form_ratio(eps), that it becomes where it is softened beyond any slip, if its optima are found from there; None:
    they are found without. rival: see `Rival`; None: a diagnosis knows it where a file says so, and does not ask.
    """

    name: str
    words: str
    title: str
    degree: int
    potential: OfSlip
    multiplier: OfSlip
    softened: bool = False
    slip: Slip = "weighed"
    softer: Law | None = None
    rival: Rival | None = None

    @property
    def variational(self) -> bool:
        """Whether its wrench is the slope of its cost."""
        return self.slip != "plain"

    def form_ratio(self, eps: Quantity) -> Quantity:
        """r: what a slip along weighs beside one across."""
        return eps ** (2 / self.degree) if self.slip == "weighed" else eps

    def cost(self, across: Quantity, along: Quantity, ratio: Quantity, softening: Quantity) -> Quantity:
        """The potential of squared slips across and along, or the work over the degree; `ratio`: r."""
        if self.slip == "weighed":
            return self.potential(across + ratio * along, softening)
        if self.slip == "parts":
            return self.potential(across, softening) + ratio * self.potential(along, softening)
        return self.multiplier(across + along, softening) * (across + ratio * along) / self.degree

    def multipliers(
        self, across: Quantity, along: Quantity, ratio: Quantity, softening: Quantity
    ) -> tuple[Quantity, Quantity]:
        """Of the force across, and of that along."""
        if self.slip == "parts":
            return self.multiplier(across, softening), self.multiplier(along, softening)
        both = self.multiplier(across + (ratio if self.slip == "weighed" else 1) * along, softening)
        return both, both

    @property
    def linear(self) -> bool:
        """Whether forces are proportional to slips: a step's energy is quadratic, eps the drag of a straight body."""
        return self.degree == 2 and not self.softened
