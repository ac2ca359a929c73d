"""A spot where tyres grip otherwise: v_n (1 + change exp(-|p - (x, y)|^2 / (2 radius^2))); wheels roll as before.

Dust, water or oil under wheels: what resists along the body is in the axles, and comes along. Where all wheels are on
the spot, the body slips sideways more easily and rolls no better: its anisotropy ratio is larger there.
"""

from __future__ import annotations

from serpenoid.effects.base import MediumEffect, Symbols
from serpenoid.effects.element import Element
from serpenoid.effects.medium import tyre_grip
from serpenoid.effects.spot import factor, scan, spot


class GripPatch(MediumEffect):
    """A slippery place, or one that grips more."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Scale what slides by the place of the vertex in the middle of the step."""
        return element.gripping(factor(element, p.change, p))


EFFECT = GripPatch(
    name="grip_patch",
    place=None,
    parameters=spot("change", "relative change of the force across wheels in the middle"),
    looks_like="residuals gather at one place on the floor, where gaits go less far (< 0) than elsewhere",
    what_to_do="clean the floor there, or move the arena",
    needs=frozenset({"wheels"}),
    rank=25,
    knows=frozenset({"place"}),
    scan=scan(tyre_grip.EFFECT, by_weight=False),
)
