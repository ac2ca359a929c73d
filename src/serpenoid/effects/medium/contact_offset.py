"""Wheels that do not sit under the joint axes: contact of the inner vertices at p - offset T (> 0 = behind)."""

from __future__ import annotations

from dataclasses import replace

from serpenoid.effects.base import MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Element


class ContactOffset(MediumEffect):
    """Head and tail keep their contacts: `present` is 1 at inner vertices only."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Move the contacts along the body."""
        (c0, c1), (t0, t1) = element.contacts, element.tangents
        return replace(element, contacts=(c0 - p.present * p.offset * t0, c1 - p.present * p.offset * t1))

    def is_present(self, vertex: int, vertices: int) -> bool:
        """Inner vertices."""
        return 0 < vertex < vertices - 1


EFFECT = ContactOffset(
    name="contact_offset",
    place=None,
    parameters=(Parameter("offset", "m", -0.2, 0.2, 0.0, 0.018, "> 0: behind the joint, towards the tail"),),
    looks_like="head-first gaits and tail-first gaits differ, at every speed alike, more so for wide waves",
    what_to_do="measure how far the wheels sit from the joint axes and put it into the model",
    needs=frozenset({"wheels"}),
    rank=5,
)
