"""A floor that is not level: every vertex is pulled by w (pull_x, pull_y), a constant direction on the floor."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from serpenoid.effects.base import Advice, MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Element

DOWNHILL = "downhill, along the floor's {}; with dry friction tan(slope) / coefficient"


class Slope(MediumEffect):
    """Pull over drag: the speed at which the body would slide sideways, downhill. With dry friction: over friction
    sideways, which is tan(slope) over its coefficient."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Pull at the vertex."""
        return replace(element, push=element.push + element.weight * ca.vertcat(p.pull_x, p.pull_y))


EFFECT = Slope(
    name="slope",
    place=None,
    parameters=(
        Parameter("pull_x", "m/s", -1.0, 1.0, 0.0, 0.003, DOWNHILL.format("x"), over_drag=True),
        Parameter("pull_y", "m/s", -1.0, 1.0, 0.0, 0.002, DOWNHILL.format("y"), over_drag=True),
    ),
    looks_like="all trials drift the same way on the floor, more so the slower they are, and in pauses too",
    what_to_do="put a level on the floor",
    needs=frozenset({"ground"}),
    of_animals=Advice(
        looks_like="the body drifts the same way on the ground, more so the slower it moves, and while it rests",
        what_to_do="put a level on the ground; in a dish, look for flow",
    ),
    knows=frozenset({"speed", "place"}),
)
