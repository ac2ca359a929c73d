"""Wheels fixed to a link instead of the joint's bisector: rolling directions turned by -share half the bend.

share 1: along the link behind (tail's side), -1: along the link ahead, 0: the mean of both, as the baseline has it.
"""

from __future__ import annotations

from dataclasses import replace

from serpenoid.effects.base import MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Element, angle_between, turned


class WheelMount(MediumEffect):
    """At head and tail, and within a link, there is no bend and nothing changes."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Turn the wheels with the link."""
        wheels = (
            turned(wheel, p.share * angle_between(tangent, link))
            for wheel, tangent, link in zip(element.wheels, element.tangents, element.links, strict=True)
        )
        return replace(element, wheels=tuple(wheels))


EFFECT = WheelMount(
    name="wheel_mount",
    place=None,
    parameters=(Parameter("share", "1", -1.0, 1.0, 0.0, 0.5, "1: along the link behind, -1: along the link ahead"),),
    looks_like="head-first gaits and tail-first gaits differ, at every speed alike, more so for wide waves",
    what_to_do="look to which link the wheels are screwed and put it into the model",
    needs=frozenset({"wheels"}),
    rank=5,
    costly=True,
)
