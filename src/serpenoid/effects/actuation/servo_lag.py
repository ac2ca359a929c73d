"""Servos that follow with a delay: q' = (q_set - q) / lag."""

from __future__ import annotations

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.base import ActuationEffect, Parameter, Symbols, Wave

FIRST_LAG = 0.03  # s: where a fit begins
INSTANT = 1e-12  # s: keeps the division defined at a lag of zero, where the answer is the set-point to the last bit


class ServoLag(ActuationEffect):
    """First order, exact for a set-point that is linear in time."""

    def respond(self, angle: ca.SX, before: ca.SX, after: ca.SX, duration: ca.SX, p: Symbols) -> ca.SX:
        """Follow the line `lag` behind, plus what is left of the deviation from it."""
        behind = p.lag * (after - before) / duration
        decay = ca.exp(-duration / (p.lag + INSTANT))
        return after - behind + (angle - before + behind) * decay

    def starts(self, readings: Floats, quickest: Floats) -> list[Floats]:
        """At rest nothing says which way a memory works."""
        return [np.full(readings.shape[1], FIRST_LAG)]

    def in_gait(self, wave: Wave, p: Symbols) -> Wave:
        """A sine comes out smaller and later: with z = exp(2 pi i / steps) by the factor (c + b / z) / (1 - a / z)."""
        duration, units = ca.SX(wave.duration), ((1, 0, 0), (0, 1, 0), (0, 0, 1))
        a, b, c = (self.respond(ca.SX(u), ca.SX(v), ca.SX(w), duration, p) for u, v, w in units)
        x, y = ca.cos(2 * ca.pi / wave.steps), -ca.sin(2 * ca.pi / wave.steps)  # 1 / z
        return wave.filtered((c + b * x, b * y), (1 - a * x, -a * y))


EFFECT = ServoLag(
    name="servo_lag",
    place=None,
    parameters=(Parameter("lag", "s", 0.0, 5.0, 0.0, 0.08, "time constant"),),
    looks_like="every servo reads a smaller and later wave than commanded; quick cycles suffer most",
    what_to_do="raise the servos' gain, lower the load, or play more slowly",
    needs=frozenset({"servos"}),
    rank=0,
    memory=1,
    needs_seconds=True,
)
