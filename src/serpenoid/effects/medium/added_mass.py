"""Mass of fluid that moves with the body sideways: momentum of w (N . v) N, as slender swimmers have it."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from serpenoid.effects.base import Advice, MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Element, left


class AddedMass(MediumEffect):
    """Anisotropic inertia; the mean of the tensors at both ends of the step, as for the drag."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Momentum of the fluid at the vertex."""
        normals = [left(tangent) for tangent in element.tangents]
        sideways = sum((ca.dot(n, element.velocity) * n for n in normals), ca.SX.zeros(2)) / 2
        return replace(element, momentum=element.momentum + p.relaxation_time * element.weight * sideways)


EFFECT = AddedMass(
    name="added_mass",
    place=None,
    parameters=(
        Parameter(
            "relaxation_time",
            "s",
            0.0,
            100.0,
            0.0,
            0.2,
            "added mass over drag (that of sliding sideways)",
            over_drag=True,
        ),
    ),
    looks_like="thrust out of phase with drag: a swimmer gets farther than any drag ratio allows; quick cycles show it",
    what_to_do="no fault: keep it in the model",
    needs=frozenset({"water"}),
    of_animals=Advice(
        looks_like="a swimmer gets farther than any ratio of drags allows, most so in quick beats",
        what_to_do="no fault: water that must be accelerated; keep it in the model",
    ),
    knows=frozenset({"speed", "history"}),
    costly=True,
)
