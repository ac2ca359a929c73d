"""An anisotropy ratio that drifts while a trial lasts: eps(t) = eps exp(rate t), afresh in every trial."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca

from serpenoid.effects.base import Advice, MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Element


class AnisotropyDrift(MediumEffect):
    """Wheels that warm up, or gather dust."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Scale the anisotropy ratio by the time since the start."""
        return replace(element, anisotropy_ratio=element.anisotropy_ratio * ca.exp(p.rate * element.time))


EFFECT = AnisotropyDrift(
    name="anisotropy_drift",
    place=None,
    parameters=(Parameter("rate", "1/s", -1.0, 1.0, 0.0, 0.05, "relative change per second"),),
    looks_like="the first cycles of a trial go farther (rate > 0) or less far (rate < 0) than the last ones",
    what_to_do="clean the axles before every trial; let the robot warm up",
    of_animals=Advice(
        looks_like="a beat goes farther at the beginning (rate > 0) or at the end (rate < 0) of a recording",
        what_to_do="look for what changes while it is filmed: moisture, a trail, water that begins to move",
    ),
    rank=10,
    knows=frozenset({"speed", "clock"}),
    scales_ratio=True,
)
