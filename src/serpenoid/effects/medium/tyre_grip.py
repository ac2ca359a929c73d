"""A tyre that grips otherwise: across the wheel v_n -> (1 + change) v_n at one vertex; it rolls as before."""

from __future__ import annotations

from serpenoid.effects.base import MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Element


class TyreGrip(MediumEffect):
    """What is pushed sideways depends on tyre and floor; what rolls, on the axle."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Scale what slides."""
        return element.gripping(1 + p.change)


EFFECT = TyreGrip(
    name="tyre_grip",
    place="vertex",
    parameters=(Parameter("change", "1", -0.999, 20.0, 0.0, -0.5, "relative change of the force across the wheel"),),
    looks_like="one vertex swings wide (< 0) or motions pivot nearer to it (> 0), at every speed alike",
    what_to_do="compare that tyre with the others: dust, wear, another rubber; clean or change it",
    needs=frozenset({"wheels"}),
    rank=21,
)
