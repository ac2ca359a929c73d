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
from typing import Any, Literal, get_args

from serpenoid.errors import InputError

Quantity = Any  # a number, an array or a symbol of CasADi's
Slip = Literal["weighed", "parts", "plain"]
OfSlip = Callable[[Quantity, Quantity], Quantity]


TRIED = 0.7, 0.03  # squared slip and softening length at which a law is tried: of no meaning
CLOSE = 1e-6  # far above the error of a central difference of steps of 1e-4 (1e-8), far below any mistake of a formula


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

    def __post_init__(self) -> None:
        fault = _fault(self)
        if fault:
            raise InputError(f"law `{self.name}`: {fault}.")

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


def _fault(law: Law) -> str | None:
    """What two functions, a degree and two words contradict each other in: simulation and NLP would not agree."""
    if law.slip not in get_args(Slip):
        return f"`slip` must be one of {', '.join(get_args(Slip))}, got {law.slip!r}"
    if not law.degree > 0:
        return f"`degree`, of the potential in the displacement, must be above 0, got {law.degree}"
    (q, s), (m, p) = TRIED, (_number(law, "multiplier"), _number(law, "potential"))
    if not m(q, s) > 0:
        return f"`multiplier` must be above 0, or it drives, got {m(q, s):g}"
    slope = (p(q + 1e-4, s) - p(q - 1e-4, s)) / 1e-4
    if law.variational and abs(slope - m(q, s)) > CLOSE * m(q, s):
        return (
            f"`multiplier` must be twice the slope of `potential` in the squared slip, got {m(q, s):.6g} where that is "
            f"{slope:.6g}, at a squared slip of {q:g}"
        )
    growth, wanted = m(4 * q, 2 * s) / m(q, s), 2 ** (law.degree - 2)
    if abs(growth - wanted) > CLOSE * wanted:
        return (
            f"`degree` must be that of `potential` in slip and softening together, got {law.degree:g}: twice the slip "
            f"makes {growth:.6g} of `multiplier` and not {wanted:.6g}"
        )
    if law.softened is not (m(q, 2 * s) != m(q, s)):
        knows = "depends" if not law.softened else "does not depend"
        return (
            f"`softened` must say whether the softening length matters, got {law.softened}: `multiplier` {knows} on it"
        )
    return None


def _number(law: Law, name: str) -> Callable[[float, float], float]:
    """One of its functions, of numbers; InputError where that gives none."""

    def at(q: float, s: float) -> float:
        value = getattr(law, name)(q, s)
        try:
            return float(value)
        except TypeError:
            cure = "Does it lack a `return`?"
            raise InputError(f"law `{law.name}`: `{name}` gives {type(value).__name__}, no number. {cure}") from None

    return at
