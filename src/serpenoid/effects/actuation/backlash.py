"""Play in one joint: it stays until the set-point has crossed the gap, then follows at half its width."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.base import ActuationEffect, Parameter, Symbols, Wave

FIRST_WIDTH = 0.02  # rad: where a fit begins


class Backlash(ActuationEffect):
    """The play operator, exact at the ends of steps in which the set-point is monotone."""

    def respond(self, angle: ca.SX, before: ca.SX, after: ca.SX, duration: ca.SX, p: Symbols) -> ca.SX:
        """Stay, or be pushed; a joint at rest stays so in the derivatives too, one without play follows."""
        half = p.width / 2
        pushed_down = ca.if_else(angle > after + half, after + half, angle)
        played = ca.if_else(angle < after - half, after - half, pushed_down)
        return ca.if_else(p.present > 0, played, after)

    def starts(self, readings: Floats, quickest: Floats) -> list[Floats]:
        """A gap that is crossed."""
        return [np.full(readings.shape[1], FIRST_WIDTH)]

    def in_gait(self, wave: Wave, p: Symbols) -> Wave:
        """Held at the highest row, followed on the way down; the same upwards. Kinks: where a row begins to follow."""
        half, steps = p.width / 2, wave.steps
        _, cosine, sine = wave.harmonic
        crest = ca.floor(ca.atan2(sine, cosine) * steps / (2 * ca.pi) + 0.5)
        trough = ca.floor((ca.atan2(sine, cosine) + ca.pi) * steps / (2 * ca.pi) + 0.5)
        highest, lowest = wave.at(crest), wave.at(trough)
        idle = ca.fmin(ca.fmax(wave.at(ca.SX(0)), highest - half), lowest + half)  # it never crosses the gap

        def at(row: ca.SX) -> ca.SX:
            angle = wave.at(row)
            down = _modulo(ca.floor(row + 0.5) - crest, steps) <= _modulo(trough - crest, steps)
            follows = ca.if_else(down, ca.fmin(highest - half, angle + half), ca.fmax(lowest + half, angle - half))
            played = ca.if_else(highest - lowest > p.width, follows, idle)
            return ca.if_else(p.present > 0, played, angle)

        return replace(wave, at=at)


def _modulo(row: ca.SX, steps: int) -> ca.SX:
    return row - steps * ca.floor(row / steps)


EFFECT = Backlash(
    name="backlash",
    place="joint",
    parameters=(Parameter("width", "rad", 0.0, 3.0, 0.0, 0.05, "full width of the gap"),),
    looks_like="one joint's wave has flat tops and is late by the same angle at every speed",
    what_to_do="replace the horn or its screw; preload the joint",
    needs=frozenset({"servos"}),
    rank=2,
    memory=1,
)
