"""A horn mounted a tooth off: true angle = servo position + offset. The servo does not know; the markers do."""

from __future__ import annotations

import casadi as ca

from serpenoid.effects.base import ActuationEffect, Parameter, Symbols


class ZeroOffset(ActuationEffect):
    """Added to what the servo reads."""

    def respond(self, angle: ca.SX, before: ca.SX, after: ca.SX, duration: ca.SX, p: Symbols) -> ca.SX:
        """Shift."""
        return after + p.offset


EFFECT = ZeroOffset(
    name="zero_offset",
    place="joint",
    parameters=(Parameter("offset", "rad", -3.2, 3.2, 0.0, 0.05, "true angle minus the servo's", resolution=5e-5),),
    looks_like="all gaits turn to the same side; the markers show a constant bend that the servo log does not",
    what_to_do="mount the horn again, or put the offset into the servo's zero",
    needs=frozenset({"servos"}),
    rank=5,
    shown=False,
    marks="zeros",
)
