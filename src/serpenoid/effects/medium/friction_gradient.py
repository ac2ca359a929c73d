"""Friction that grows across the floor: F -> F exp(gradient . p)."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from serpenoid.effects.base import Advice, MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Element


class FrictionGradient(MediumEffect):
    """One end of the arena grips better than the other."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Scale the grip by the place of the vertex in the middle of the step."""
        x, y = ca.vertsplit(element.place)
        return replace(element, grip=element.grip * ca.exp(p.gradient_x * x + p.gradient_y * y))


EFFECT = FrictionGradient(
    name="friction_gradient",
    place=None,
    parameters=(
        Parameter("gradient_x", "1/m", -10.0, 10.0, 0.0, 0.5, "relative change per metre along the floor's x"),
        Parameter("gradient_y", "1/m", -10.0, 10.0, 0.0, 0.5, "relative change per metre along the floor's y"),
    ),
    looks_like="the body turns towards the side of the floor that grips, depending on its heading there",
    what_to_do="look at how the mats lie and where they are worn",
    needs=frozenset({"ground"}),
    of_animals=Advice(
        looks_like="the body turns towards the side of the ground that resists more, depending on its heading there",
        what_to_do="look how ground or agar change from one side to the other: moisture, thickness, food",
    ),
    rank=25,
    knows=frozenset({"place"}),
)
