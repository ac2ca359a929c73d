"""Drag of swimmers at high Reynolds number: E = w q^(3/2) / 3, forces grow with the square of the speed.

    q = v_n^2 + eps^(2/3) v_t^2,   force = -w sqrt(q) (v_n N + eps^(2/3) v_t T)

eps is the drag of a straight body that moves lengthwise over that of one that moves sideways, at the same speed. One
speed past the body, sqrt(q), decides on both parts of the force; Taylor (1952) takes the pressure on a cylinder in
oblique flow, v_n^2, for independent of the flow along it, which is another law.

Softened: ((q + s^2)^(3/2) - s^3) / 3, s as for dry friction: at a slip of zero drag has no slope, and its derivative no
second one. The law stays blind to speed and to the number of steps.
"""

from __future__ import annotations

from serpenoid.media.base import Law, Quantity, Rival
from serpenoid.media.viscous import LAW as VISCOUS


def _potential(q: Quantity, softening: Quantity) -> Quantity:
    return ((q + softening**2) ** 1.5 - softening**3) / 3


def _multiplier(q: Quantity, softening: Quantity) -> Quantity:
    return (q + softening**2) ** 0.5


LAW = Law(
    name="quadratic",
    words="quadratic drag",
    title="quadratic drag",
    degree=3,
    potential=_potential,
    multiplier=_multiplier,
    softened=True,
    rival=Rival(VISCOUS, "quadratic drag", frozenset({"water"})),
)
