"""Coulomb friction with a friction ellipse: E = w sqrt(q), of degree one in the displacement, blind to speed.

    q = v_n^2 + eps^2 v_t^2,   force = -w (v_n N + eps^2 v_t T) / sqrt(q):  f_n^2 + (f_t / eps)^2 = w^2

eps is the ratio of the friction coefficients, tangential over normal; w is proportional to the load. The slip is normal
to the ellipse of forces (an associated law), so it has a potential, and the step one minimum at each turn. For small
slip angles the side force is 1 / eps^2 times the tangential one times the slip angle: that ratio is the transverse
coefficient of laws whose force is eps and 1 times the direction of slip (Alben 2013).

Softened: sqrt(q + s^2) - s, with s a share (`softening`) of the way that the element itself goes in the step in the
body frame: of the change of shape, whatever the pose. So the law stays blind to speed and to the number of steps;
elements that would stick creep by a share of that way.
"""

from __future__ import annotations

from serpenoid.media.base import Law, Quantity, Rival
from serpenoid.media.viscous import LAW as VISCOUS


def _potential(q: Quantity, softening: Quantity) -> Quantity:
    return (q + softening**2) ** 0.5 - softening


def _multiplier(q: Quantity, softening: Quantity) -> Quantity:
    return 1 / (q + softening**2) ** 0.5


LAW = Law(
    name="coulomb",
    words="dry friction",
    title="dry friction",
    degree=1,
    potential=_potential,
    multiplier=_multiplier,
    softened=True,
    softer=VISCOUS,
    rival=Rival(VISCOUS, "dry friction (Coulomb)", frozenset({"ground"})),
)
