"""Servos that cannot keep up: q follows q_set with |q'| <= max_speed."""

from __future__ import annotations

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.base import ActuationEffect, Parameter, Symbols, Values, Wave

SATURATED = (0.9, 0.7, 0.5, 0.3)  # of the quickest set-point: where fits begin


class SpeedSaturation(ActuationEffect):
    """The coordinate is 1 / max_speed. Exact for a set-point that is linear in time."""

    def respond(self, angle: ca.SX, before: ca.SX, after: ca.SX, duration: ca.SX, p: Symbols) -> ca.SX:
        """Go as far as the speed allows; a set-point that is too quick is not followed once it is met, and a servo that
        it comes towards turns round. Written without the division by a coordinate of zero."""
        wanted, run = after - angle, after - before
        excess = ca.fmax(1.0, p.max_speed * ca.fabs(wanted) / duration)
        met = ca.if_else(excess > 1, angle + wanted / excess, after)
        quick = p.max_speed * ca.fabs(run)
        reach = ca.fabs(run) * duration / ca.fmax(quick, duration)
        till = p.max_speed * ca.sign(run) * (angle - before) / (duration + quick)  # they meet, as a share of the step
        passed = angle + ca.sign(run) * reach * ca.fmax(-1.0, ca.fmin(1.0, 1 - 2 * till))
        return ca.if_else(quick > duration, passed, met)

    def starts(self, readings: Floats, quickest: Floats) -> list[Floats]:
        """Above the quickest set-point a saturation changes nothing."""
        own = quickest if self.place else np.full_like(quickest, quickest.max())
        (speed,) = self.parameters
        return [1 / np.maximum(share * own, speed.lower) for share in SATURATED]

    def in_gait(self, wave: Wave, p: Symbols) -> Wave:
        """Unchanged: an optimised gait keeps the speed limit, so that it is played as it is commanded."""
        return wave

    def speed_limit(self, values: Values) -> float:
        """The speed that the servos have."""
        return values["max_speed"]


EFFECT = SpeedSaturation(
    name="speed_saturation",
    place=None,
    parameters=(Parameter("max_speed", "rad/s", 1e-2, float("inf"), float("inf"), 0.5, "no joint turns faster", -1),),
    looks_like="triangle waves instead of sines in quick cycles; slow cycles are unharmed",
    what_to_do="charge the battery, or limit the gait's joint speed",
    needs=frozenset({"servos"}),
    rank=1,
    memory=1,
    limits=True,
    needs_seconds=True,
)
