"""Drag that grows with a power of the speed: F -> F (|v| / 0.1 m/s)^(exponent - 1); 1 = linear, 0 = dry."""

from __future__ import annotations

from serpenoid.effects.base import Advice, MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Drag

REFERENCE_SPEED = 0.1  # m/s; a unit only: the path does not depend on it


class PowerLawDrag(MediumEffect):
    """A homogeneous law: the path is the same at every speed of replay."""

    def on_drag(self, drag: Drag, p: Symbols) -> Drag:
        """Scale with the speed."""
        return drag.by_speed((drag.speed / REFERENCE_SPEED) ** (p.exponent - 1))


EFFECT = PowerLawDrag(
    name="power_law_drag",
    place=None,
    parameters=(Parameter("exponent", "1", 0.0, 3.0, 1.0, 0.6, "of the speed in the force"),),
    looks_like="fast vertices count for more (> 1) or less (< 1) than with linear drag, at every speed alike",
    what_to_do="no fault: the material of floor or skin; keep the exponent in the model",
    of_animals=Advice(
        looks_like="fast parts of the body count for more (> 1) or less (< 1) than with linear drag, at every speed",
        what_to_do="no fault: how water, mucus or ground resist; keep the exponent in the model",
    ),
    rank=30,
    knows=frozenset({"speed"}),
    of_degree=2,
    costly=True,
)
