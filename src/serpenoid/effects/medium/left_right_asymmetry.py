"""Unequal resistance to the two sides: normal coefficient 1 -> 1 + asymmetry sgn v_n; > 0 is harder to the left."""

from __future__ import annotations

from dataclasses import replace

from serpenoid.effects.base import Advice, MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Drag, soft_sign


class LeftRightAsymmetry(MediumEffect):
    """Wheels that bite better on one side."""

    def on_drag(self, drag: Drag, p: Symbols) -> Drag:
        """Scale the normal part by the side to which the vertex slips."""
        return replace(drag, normal=drag.normal * (1 + p.asymmetry * soft_sign(drag.sideways)))


EFFECT = LeftRightAsymmetry(
    name="left_right_asymmetry",
    place=None,
    parameters=(Parameter("asymmetry", "1", -1.0, 1.0, 0.0, 0.3, "> 0: harder to the left"),),
    looks_like="all gaits, head first or tail first, drift to the same side of the body",
    what_to_do="look for tyres worn on one side, or a body that leans",
    of_animals=Advice(
        looks_like="the body drifts to the same side whichever way it swims or crawls",
        what_to_do="look whether it leans, or rubs along a wall on one side",
    ),
    rank=30,
    knows=frozenset({"speed"}),
    scales_ratio=True,
    costly=True,
)
