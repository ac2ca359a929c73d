"""Lateral grip that gives way: normal force v_n / sqrt(1 + (v_n / saturation_speed)^2); along the wheel unchanged."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from serpenoid.effects.base import MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Drag


class GripSaturation(MediumEffect):
    """Wheels that slip sideways when asked for too much. The coordinate is 1 / saturation_speed^2."""

    def on_drag(self, drag: Drag, p: Symbols) -> Drag:
        """Bound the normal force."""
        return replace(drag, normal=drag.normal / ca.sqrt(1 + p.saturation_speed * drag.sideways**2))


EFFECT = GripSaturation(
    name="grip_saturation",
    place=None,
    parameters=(
        Parameter("saturation_speed", "m/s", 1e-3, float("inf"), float("inf"), 0.1, "sideways speed of slipping", -2),
    ),
    looks_like="quick cycles and wide waves slip sideways and lose way; slow ones follow the baseline",
    what_to_do="clean or change the tyres, or play the gait more slowly",
    rank=30,
    knows=frozenset({"speed"}),
)
