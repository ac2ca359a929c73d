"""A floor that sags: every vertex is pulled by w rate towards the middle of the room."""

from __future__ import annotations

from dataclasses import replace

from serpenoid.effects.base import MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Element


class SaggingFloor(MediumEffect):
    """Downhill, the more so the farther from the middle."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Pull at the vertex."""
        return replace(element, push=element.push - p.rate * element.weight * element.place)


EFFECT = SaggingFloor(
    name="sagging_floor",
    place=None,
    parameters=(Parameter("rate", "1/s", -1.0, 1.0, 0.0, 0.01, "speed downhill for each metre from the middle"),),
    looks_like="the body drifts to the middle of the floor from wherever it is",
    what_to_do="support the floor in the middle",
    needs=frozenset({"ground"}),
    knows=frozenset({"speed", "place"}),
)
