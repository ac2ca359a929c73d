"""Grip that gives way: normal force v_n / sqrt(1 + (u / saturation_speed)^2); along a rolling wheel unchanged.

The slip u is v_n; where a wheel is seized or an axle scrubs, it is (v_n, seizure v_t, scrub) and all of it gives way.
"""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from serpenoid.effects.base import Advice, MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Drag


class GripSaturation(MediumEffect):
    """Wheels that slip sideways when asked for too much. The coordinate is 1 / saturation_speed^2."""

    def on_drag(self, drag: Drag, p: Symbols) -> Drag:
        """Bound the force of what slides."""
        slip = drag.sideways**2 + drag.scrub + (drag.locked * drag.forward) ** 2
        share = ca.sqrt(1 + p.saturation_speed * slip)
        return replace(drag, normal=drag.normal / share, sliding=drag.sliding / share)


EFFECT = GripSaturation(
    name="grip_saturation",
    place=None,
    parameters=(
        Parameter("saturation_speed", "m/s", 1e-3, float("inf"), float("inf"), 0.1, "sideways speed of slipping", -2),
    ),
    looks_like="quick cycles and wide waves slip sideways and lose way; slow ones follow the baseline",
    what_to_do="clean or change the tyres, or play the gait more slowly",
    needs=frozenset({"ground"}),
    of_animals=Advice(
        looks_like="quick cycles and wide waves slip sideways and lose way; slow ones follow the baseline",
        what_to_do="no fault: the ground gives way; keep it in the model, or offer a rougher one",
    ),
    rank=30,
    knows=frozenset({"speed"}),
    of_degree=2,  # what bounds the force of dry friction once more lets it fall to nothing
    costly=True,
)
