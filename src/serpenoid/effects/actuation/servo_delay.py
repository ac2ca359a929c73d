"""Servos that do everything late by the same time: q(t) = q_set(t - delay), as a bus that answers late makes it."""

from __future__ import annotations

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.base import ActuationEffect, Parameter, Symbols, Wave

BEGUN = 10e-3 * 2.0 ** np.arange(5)  # s: where fits begin, an octave apart: far from it, what is late gains nothing
SEEN = 2e-3  # s: of readings a hundredth of a second apart, a fifth of those beside a jump are moved across it


class ServoDelay(ActuationEffect):
    """A dead time. It changes when servos are told, not what they make of it."""

    def respond(self, angle: ca.SX, before: ca.SX, after: ca.SX, duration: ca.SX, p: Symbols) -> ca.SX:
        """As they are told, once they are."""
        return after

    def starts(self, readings: Floats, quickest: Floats) -> list[Floats]:
        """Of a wave, only delays that are nearer than a part of a cycle lead to one another."""
        return [np.full(readings.shape[1], delay) for delay in BEGUN]

    def in_gait(self, wave: Wave, p: Symbols) -> Wave:
        """Rows are those between which the earlier ones were told, on straight lines."""
        return wave.later(p.delay / wave.duration)


EFFECT = ServoDelay(
    name="servo_delay",
    place=None,
    parameters=(Parameter("delay", "s", 0.0, 5.0, 0.0, 0.05, "dead time", across=SEEN),),
    looks_like="every servo reads the commanded wave whole, corners and all, and later by the same time at every speed",
    what_to_do="look for what holds commands back: latency of the bus or its adapter, a slow control loop, a filter",
    needs=frozenset({"servos"}),
    rank=-1,
    dead_time=True,
    needs_seconds=True,
)
