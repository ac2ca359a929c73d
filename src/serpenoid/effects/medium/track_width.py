"""Wheels in pairs on one axle: when the axle turns at Omega they scrub, with a moment -w half_track^2 Omega."""

from __future__ import annotations

from dataclasses import replace

from serpenoid.effects.base import MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Element


class TrackWidth(MediumEffect):
    """Turning on the spot costs; where the grip is saturated it also takes grip from the sides.

    The coordinate is half_track^2.
    """

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Set the wheels apart."""
        return replace(element, axle=p.half_track)


EFFECT = TrackWidth(
    name="track_width",
    place=None,
    parameters=(Parameter("half_track", "m", 0.0, 0.5, 0.0, 0.1, "from the middle of the axle to a wheel", 2),),
    looks_like="the body turns less than it should where it bends most, in every gait and at every speed alike",
    what_to_do="measure the distance of the wheels; narrow the axles, or let both wheels of a pair turn freely",
    needs=frozenset({"wheels"}),
    rank=20,
    costly=True,
)
