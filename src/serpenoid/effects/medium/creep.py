"""Dry friction that gives way below a speed: F -> F / (1 + (creep_speed / |v|)^sharpness)^(1 / sharpness); 0 = rigid.

Tyres, feet and scales shear before they slide, and contacts in simulators of rigid bodies creep, so that forces are
unique. Far below the creep speed the floor resists as linear drag does, far above it as dry friction; sharpness says
how suddenly one becomes the other: 2 = v / sqrt(v^2 + c^2), about 2.7 = tanh(v / c), much more = a kink.
"""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from serpenoid.effects.base import Advice, MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Drag

NONE = 1e-30  # of the creep speed over the slip: the derivative by the sharpness is that of nothing


class Creep(MediumEffect):
    """Slips that soften the law in addition to its own softening. A multiplier of dry friction is 1 / |v|."""

    def on_drag(self, drag: Drag, p: Symbols) -> Drag:
        """Soften the friction of each way."""

        def softened(multiplier: ca.SX) -> ca.SX:
            slower = ca.exp(p.sharpness * ca.log(p.creep_speed * multiplier + NONE))
            return multiplier / (1 + slower) ** (1 / p.sharpness)

        return replace(drag, across=softened(drag.across), along=softened(drag.along))


EFFECT = Creep(
    name="creep",
    place=None,
    parameters=(
        Parameter("creep_speed", "m/s", 0.0, 1.0, 0.0, 0.01, "slip below which friction gives way"),
        Parameter("sharpness", "1", 1.0, 20.0, None, 2.0, "how suddenly it gives way"),
    ),
    looks_like="slow parts of the body slip where dry friction would hold them; slow cycles slip more than quick ones",
    what_to_do="no fault: tyres or soles that shear, a floor that yields; keep it in the model",
    needs=frozenset({"ground"}),
    of_animals=Advice(
        looks_like="slow parts slip where dry friction would hold them; slow beats slip more than quick ones",
        what_to_do="no fault: skin that shears, ground that yields; keep it in the model",
    ),
    rank=40,  # softens what the law and other effects make of it
    knows=frozenset({"speed"}),
    of_degree=1,
    of_the_law=True,
    costly=True,
)
