"""Dry friction that gives way below a speed: F -> F |v| / sqrt(|v|^2 + creep_speed^2); 0 = as dry as it can be.

Tyres, feet and scales shear before they slide, and contacts in simulators of rigid bodies creep, so that forces are
unique. Far below the creep speed the floor resists as linear drag does, far above it as dry friction.
"""

from __future__ import annotations

from dataclasses import replace

from serpenoid.effects.base import Advice, MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Element


class Creep(MediumEffect):
    """A slip that softens the law in addition to its own softening. The coordinate is creep_speed^2."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Soften the friction."""
        return replace(element, creep=p.creep_speed)


EFFECT = Creep(
    name="creep",
    place=None,
    parameters=(Parameter("creep_speed", "m/s", 0.0, 1.0, 0.0, 0.01, "slip below which friction gives way", 2),),
    looks_like="slow parts of the body slip where dry friction would hold them; slow cycles slip more than quick ones",
    what_to_do="no fault: tyres or soles that shear, a floor that yields; keep it in the model",
    needs=frozenset({"ground"}),
    of_animals=Advice(
        looks_like="slow parts slip where dry friction would hold them; slow beats slip more than quick ones",
        what_to_do="no fault: skin that shears, ground that yields; keep it in the model",
    ),
    rank=30,
    knows=frozenset({"speed"}),
    of_degree=1,
    of_the_law=True,
)
