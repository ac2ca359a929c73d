"""A spot where tyres grip otherwise: v_n (1 + change exp(-|p - (x, y)|^2 / (2 radius^2))); wheels roll as before.

Dust, water or oil under wheels: what resists along the body is in the axles, and comes along. Where all wheels are on
the spot, the body slips sideways more easily and rolls no better: its anisotropy ratio is larger there.
"""

from __future__ import annotations

import casadi as ca

from serpenoid.effects.base import MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Element
from serpenoid.effects.medium import friction_patch, tyre_grip
from serpenoid.effects.scan import Scan


class GripPatch(MediumEffect):
    """A slippery place, or one that grips more."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Scale what slides by the place of the vertex in the middle of the step."""
        away = element.place - ca.vertcat(p.x, p.y)
        return element.gripping(1 + p.change * ca.exp(-ca.dot(away, away) / (2 * p.radius**2)))


EFFECT = GripPatch(
    name="grip_patch",
    place=None,
    parameters=(
        Parameter("change", "1", -0.999, 20.0, 0.0, 2.0, "relative change of the force across wheels in the middle"),
        Parameter("x", "m", -100.0, 100.0, None, 0.2, "middle of the patch on the floor"),
        Parameter("y", "m", -100.0, 100.0, None, 0.1, "middle of the patch on the floor"),
        Parameter("radius", "m", 0.01, 10.0, None, 0.2, "where it has fallen to 61 %"),
    ),
    looks_like="residuals gather at one place on the floor, where gaits go less far (< 0) than elsewhere",
    what_to_do="clean the floor there, or move the arena",
    needs=frozenset({"wheels"}),
    rank=25,
    knows=frozenset({"place"}),
    scan=Scan(
        made_of=tyre_grip.EFFECT.name,
        by_weight=False,
        size="radius",
        begins=(-0.9, 3.0),
        grids=friction_patch.grids,
    ),
)
