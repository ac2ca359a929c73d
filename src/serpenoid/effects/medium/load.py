"""More or less weight on one vertex: what rests there changes by `share` of the whole body's weight.

Drag, pull of a slope and momentum are all in proportion to what rests on a vertex: however a body is loaded, it slides
down a slope at the same speed, and coasts as long.
"""

from __future__ import annotations

from dataclasses import replace

from serpenoid.body import Body
from serpenoid.effects.base import Advice, MediumEffect, Parameter, Symbols, Values
from serpenoid.effects.element import Element


class Load(MediumEffect):
    """A payload (share > 0), or a vertex that is lifted off the floor (share < 0; contact lost at minus its weight)."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        """A payload is dragged along, and weighs on a slope."""
        return replace(element, grip=element.grip + p.share, weight=element.weight + p.share)

    def coordinate_bounds(self, body: Body, place: int | None) -> list[tuple[float, float]]:
        """From lost contact upwards."""
        return [(-float(body.vertex_weights[place or 0]), self.parameters[0].upper)]

    def fault(self, body: Body, place: int | None, values: Values) -> str | None:
        """No less than nothing can rest on a vertex."""
        least = -float(body.vertex_weights[place or 0])
        if values["share"] >= least - 1e-12:
            return None
        return f"`load`: `share` at vertex {place} must be at least {least:.4g}, the contact is lost there"


EFFECT = Load(
    name="load",
    place="vertex",
    parameters=(Parameter("share", "1", -1.0, 10.0, 0.0, 0.1, "of the body's weight, added at the vertex"),),
    looks_like="motions pivot nearer to one vertex (payload) or it swings wide (contact lost), at every speed alike",
    what_to_do="weigh the modules; check that every wheel touches the floor",
    needs=frozenset({"ground"}),
    of_animals=Advice(
        looks_like="motions pivot nearer to one part of the body (it presses harder) or that part swings wide (lifted)",
        what_to_do="film from the side: does the animal lift or press down this part?",
    ),
    rank=5,
)
