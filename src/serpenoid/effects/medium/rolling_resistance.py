"""Dry resistance to rolling: tangential force eps (v_t + crossover_speed v_t / |v_t|); across the wheel unchanged."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from serpenoid.effects.base import MediumEffect, Parameter, Symbols
from serpenoid.effects.element import CREEP, Drag


class RollingResistance(MediumEffect):
    """Bearings and tyres that resist at any speed; the norm is softened below 1 mm/s."""

    def on_drag(self, drag: Drag, p: Symbols) -> Drag:
        """Add the part that does not know speed."""
        return replace(drag, dry=p.crossover_speed / ca.sqrt(drag.forward**2 + CREEP**2))


EFFECT = RollingResistance(
    name="rolling_resistance",
    place=None,
    parameters=(Parameter("crossover_speed", "m/s", 0.0, 5.0, 0.0, 0.05, "speed at which both parts are equal"),),
    looks_like="slow cycles slip back more than quick ones, though nothing slides sideways; slopes do not matter",
    what_to_do="clean and oil the axles; expect it with ball bearings and soft tyres",
    needs=frozenset({"wheels"}),
    rank=31,
    knows=frozenset({"speed"}),
    of_degree=2,
    costly=True,
)
