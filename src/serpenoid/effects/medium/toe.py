"""Wheels set at an angle to the body: rolling directions turned by `angle` (left > 0) at every vertex."""

from __future__ import annotations

from dataclasses import replace

from serpenoid.effects.base import MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Element, turned


class Toe(MediumEffect):
    """The body crabs: what rolls is not along the body."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Turn the wheels."""
        before, after = element.wheels
        return replace(element, wheels=(turned(before, p.angle), turned(after, p.angle)))


EFFECT = Toe(
    name="toe",
    place=None,
    parameters=(Parameter("angle", "rad", -0.8, 0.8, 0.0, 0.05, "left > 0"),),
    looks_like="the body crabs: displacement turns against the heading by the same angle in every gait",
    what_to_do="square the wheel mounts to the links",
    needs=frozenset({"wheels"}),
    rank=20,
)
