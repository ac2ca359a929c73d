"""Mass that keeps moving: the momenta of w v change by the drag's force and moment, within `relaxation_time`."""

from __future__ import annotations

from dataclasses import replace

from serpenoid.effects.base import Advice, MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Element


class Inertia(MediumEffect):
    """A body that coasts. The massless baseline is the limit of a vanishing relaxation time."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Momentum of the vertex."""
        moving = p.relaxation_time * element.weight * element.velocity
        return replace(element, momentum=element.momentum + moving)


EFFECT = Inertia(
    name="inertia",
    place=None,
    parameters=(
        Parameter(
            "relaxation_time", "s", 0.0, 100.0, 0.0, 0.2, "mass over drag (that of sliding sideways)", over_drag=True
        ),
    ),
    looks_like="the body lags behind its shape, overshoots, and coasts into the pauses; quick cycles show it most",
    what_to_do="no fault: keep it in the model, or play the gait more slowly",
    of_animals=Advice(
        looks_like="the body lags behind its shape, overshoots, and glides on when bending stops; quick beats show it",
        what_to_do="no fault: keep it in the model",
    ),
    knows=frozenset({"speed", "history"}),
)
