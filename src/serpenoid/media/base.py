"""A dissipation law: what a slip of an element costs.

    a = (<dp, T>^2 + <dp, T'>^2) / 2,   n = |dp|^2 - a      squared slip along and across; T, T' before and after
    E = sum_k w_k potential(n + r a),   r = eps^(2 / degree)            one slip, whatever its direction
    E = sum_k w_k (potential(n) + r potential(a)),   r = eps            each way on its own (`by_components`)
    force = -w (m_n <dp, N> N + r m_a <dp, T> T),   multipliers m = 2 d potential

A law is a function of one number, and its wrench is the linear one times multipliers that both ends of the step share;
of one slip both are the same. eps is lengthwise over sideways force, of slips of one size.
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
    depends on the softening length. by_components: whether slips across and along resist each on its own. softer: the
    linear law, with the ratio form_ratio(eps), that it becomes where it is softened beyond any slip, if its optima are
    found from there; None: they are found without. rival: see `Rival`; None: a diagnosis knows it where a file says so,
    and does not ask for it.
    """

    name: str
    words: str
    title: str
    degree: int
    potential: OfSlip
    multiplier: OfSlip
    softened: bool = False
    by_components: bool = False
    softer: Law | None = None
    rival: Rival | None = None

    def form_ratio(self, eps: Quantity) -> Quantity:
        """r: what a slip along weighs beside one across."""
        return eps if self.by_components else eps ** (2 / self.degree)

    def cost(self, across: Quantity, along: Quantity, ratio: Quantity, softening: Quantity) -> Quantity:
        """The potential of squared slips across and along; `ratio`: r."""
        if self.by_components:
            return self.potential(across, softening) + ratio * self.potential(along, softening)
        return self.potential(across + ratio * along, softening)

    def multipliers(
        self, across: Quantity, along: Quantity, ratio: Quantity, softening: Quantity
    ) -> tuple[Quantity, Quantity]:
        """Of the force across, and of that along."""
        if self.by_components:
            return self.multiplier(across, softening), self.multiplier(along, softening)
        both = self.multiplier(across + ratio * along, softening)
        return both, both

    @property
    def linear(self) -> bool:
        """Whether forces are proportional to slips: a step's energy is quadratic, eps the drag of a straight body."""
        return self.degree == 2 and not self.softened
