"""A spot on the floor with other friction: F -> F (1 + strength exp(-|p - (x, y)|^2 / (2 radius^2)))."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from serpenoid.effects.base import Advice, MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Element


class FrictionPatch(MediumEffect):
    """A wet, dusty or rough place."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Scale the grip by the place of the vertex in the middle of the step."""
        away = element.place - ca.vertcat(p.x, p.y)
        factor = 1 + p.strength * ca.exp(-ca.dot(away, away) / (2 * p.radius**2))
        return replace(element, grip=element.grip * factor)


EFFECT = FrictionPatch(
    name="friction_patch",
    place=None,
    parameters=(
        Parameter("strength", "1", -0.999, 20.0, 0.0, 2.0, "relative change of friction in the middle"),
        Parameter("x", "m", -100.0, 100.0, None, 0.2, "middle of the patch on the floor"),
        Parameter("y", "m", -100.0, 100.0, None, 0.1, "middle of the patch on the floor"),
        Parameter("radius", "m", 0.01, 10.0, None, 0.2, "where it has fallen to 61 %"),
    ),
    looks_like="residuals gather at one place on the floor, whichever vertex is there",
    what_to_do="clean the floor there, or move the arena",
    needs=frozenset({"ground"}),
    of_animals=Advice(
        looks_like="residuals gather at one place on the ground, whichever part of the body is there",
        what_to_do="look at the ground there: moisture, food, a scratch",
    ),
    rank=25,
    knows=frozenset({"place"}),
)
