"""Skin that rubs more along the body at one vertex, or less: eps -> eps (1 + roughness) there; across as before.

What `worn_wheel` is to wheels: in linear drag the same force, roughness = seizure (1 - eps) / eps. As a share of eps it
also tells skin that is smoother than the rest, and what a skin that rubs along as across (eps = 1) lacks or has more,
where a seizure says nothing.
"""

from __future__ import annotations

from dataclasses import replace

from serpenoid.effects.base import MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Element


class RoughSkin(MediumEffect):
    """One vertex resists along the body more than the others, or less."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Scale the anisotropy ratio there."""
        return replace(element, anisotropy_ratio=element.anisotropy_ratio * (1 + p.roughness))


EFFECT = RoughSkin(
    name="rough_skin",
    place="vertex",
    parameters=(
        Parameter(
            "roughness", "1", -1.0, 20.0, 0.0, 0.5, "relative change of drag along the body: 1 = twice, -0.5 = half"
        ),
    ),
    looks_like="the body is held back and turns about one vertex (> 0), or slides more easily there (< 0), in every "
    "gait and at every speed alike",
    what_to_do="look there for skin, scales or feet that are torn, worn or loose, for glue, a raised screw or hair",
    needs=frozenset({"servos", "skin"}),  # of animals, whose parts all differ a little, it makes eps less sure
    rank=20,
)
