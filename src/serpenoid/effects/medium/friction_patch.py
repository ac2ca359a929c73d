"""A spot on the floor with other friction: F -> F (1 + strength exp(-|p - (x, y)|^2 / (2 radius^2)))."""

from __future__ import annotations

from dataclasses import replace

from serpenoid.effects.base import Advice, MediumEffect, Symbols
from serpenoid.effects.element import Element
from serpenoid.effects.medium import load
from serpenoid.effects.spot import factor, scan, spot


class FrictionPatch(MediumEffect):
    """A wet, dusty or rough place."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Scale the grip by the place of the vertex in the middle of the step."""
        return replace(element, grip=element.grip * factor(element, p.strength, p))


EFFECT = FrictionPatch(
    name="friction_patch",
    place=None,
    parameters=spot("strength", "relative change of friction in the middle"),
    looks_like="residuals gather at one place on the floor, whichever vertex is there",
    what_to_do="clean the floor there, or move the arena",
    needs=frozenset({"ground"}),
    of_animals=Advice(
        looks_like="residuals gather at one place on the ground, whichever part of the body is there",
        what_to_do="look at the ground there: moisture, food, a scratch",
    ),
    rank=25,
    knows=frozenset({"place"}),
    scan=scan(load.EFFECT, by_weight=True),
)
