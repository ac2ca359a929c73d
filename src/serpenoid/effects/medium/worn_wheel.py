"""A wheel that no longer rolls freely: eps -> eps + seizure (1 - eps) at one vertex; 1 = seized, no direction left.

What is locked slides, and its force is limited by the grip; what the other effects say of rolling concerns the rest.
"""

from __future__ import annotations

from dataclasses import replace

from serpenoid.effects.base import MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Element


class WornWheel(MediumEffect):
    """One vertex resists along the body as well."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Lock a share of the wheel."""
        return replace(element, locked=p.seizure)


EFFECT = WornWheel(
    name="worn_wheel",
    place="vertex",
    parameters=(Parameter("seizure", "1", 0.0, 1.0, 0.0, 0.5, "0 = rolls as the others, 1 = does not roll"),),
    looks_like="the body is held back and turns about one vertex, in every gait and at every speed alike",
    what_to_do="look for hair and dirt in the axle of that wheel; replace it",
    needs=frozenset({"wheels"}),
    rank=20,
)
