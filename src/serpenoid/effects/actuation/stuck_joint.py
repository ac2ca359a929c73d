"""A joint that does not move: q = angle, whatever is commanded."""

from __future__ import annotations

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.base import ActuationEffect, Parameter, Symbols, Values


class StuckJoint(ActuationEffect):
    """It has no neutral value; at angle 0 it is a gain loss of 1."""

    def respond(self, angle: ca.SX, before: ca.SX, after: ca.SX, duration: ca.SX, p: Symbols) -> ca.SX:
        """Replace, where it is present."""
        return after + p.present * (p.angle - after)

    def held_at(self, values: Values) -> float | None:
        """Where it is stuck."""
        return values["angle"]

    def starts(self, readings: Floats, quickest: Floats) -> list[Floats]:
        """Where each joint is most of the time."""
        return [np.nanmedian(np.where(np.isfinite(readings).any(axis=0), readings, 0.0), axis=0)]


EFFECT = StuckJoint(
    name="stuck_joint",
    place="joint",
    parameters=(Parameter("angle", "rad", -3.2, 3.2, None, 0.1, "where it is stuck"),),
    looks_like="one joint reads the same angle all the time",
    what_to_do="look for the servo's error light; reboot or replace it",
    needs=frozenset({"servos"}),
    rank=4,
)
