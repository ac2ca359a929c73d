"""Servos that follow with a delay: q' = (q_set - q) / lag."""

from __future__ import annotations

import casadi as ca

from serpenoid.effects.base import ActuationEffect, Parameter, Symbols

INSTANT = 1e-9  # s: keeps the division defined at a lag of zero, where the answer is the set-point to the last bit


class ServoLag(ActuationEffect):
    """First order, exact for a set-point that is linear in time."""

    def respond(self, angle: ca.SX, before: ca.SX, after: ca.SX, duration: ca.SX, p: Symbols) -> ca.SX:
        """Follow the line `lag` behind, plus what is left of the deviation from it."""
        behind = p.lag * (after - before) / duration
        decay = ca.exp(-duration / (p.lag + INSTANT))
        return after - behind + (angle - before + behind) * decay


EFFECT = ServoLag(
    name="servo_lag",
    place=None,
    parameters=(Parameter("lag", "s", 0.0, 5.0, 0.0, 0.08, "time constant"),),
    looks_like="every servo reads a smaller and later wave than commanded; quick cycles suffer most",
    what_to_do="raise the servos' gain, lower the load, or play more slowly",
    rank=0,
    memory=True,
    needs_seconds=True,
)
