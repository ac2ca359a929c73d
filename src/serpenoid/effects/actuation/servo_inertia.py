"""Servos with inertia: (lag / 2 damping)^2 q'' + lag q' + q = q_set, a position loop of second order.

Natural frequency w = 2 damping / lag. Below a damping of one they overshoot and ring; the higher it is, the nearer they
come to `servo_lag` with the same lag, which is how late slow motion is with either.

Legend: c = 1 / damping^2, the coordinate; e, h: of where a joint is, and of where it would be a lag later at its rate,
the deviation from what they are when transients have died; s: time over lag, so that e' = h - e, h' = -e + (1 - 4/c) h.
"""

from __future__ import annotations

from math import factorial

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.actuation.servo_lag import FIRST_LAG, INSTANT
from serpenoid.effects.base import ActuationEffect, Parameter, Symbols, Wave

FIRST_DAMPING = 0.7  # where a fit begins: between ringing and creeping
FORGOTTEN = 1e6  # lags: nothing is left of any transient
SURE = 1e-15  # keeps 1 / c defined where the law is of first order
TERMS = 10  # of series in arguments below one: the rest is below rounding


class ServoInertia(ActuationEffect):
    """Second order, exact for a set-point that is linear in time."""

    def respond(self, angle: ca.SX, before: ca.SX, after: ca.SX, duration: ca.SX, p: Symbols) -> ca.SX:
        """Follow the line `lag` behind, plus what is left of the deviation from it."""
        behind = p.lag * (after - before) / duration
        own, along, across = _fading(duration, p)
        e, h = angle[0] - before + behind, angle[1] - before
        return ca.vertcat(
            after - behind + (own + along) * e + across * h,
            after - across * e + (own - along) * h,
        )

    def starts(self, readings: Floats, quickest: Floats) -> list[Floats]:
        """At rest nothing says which way a memory works."""
        first = [[FIRST_LAG], [self.parameters[1].coordinate(FIRST_DAMPING)]]
        return [np.tile(first, (1, readings.shape[1]))]

    def in_gait(self, wave: Wave, p: Symbols) -> Wave:
        """A sine comes out of x' = F x + b u + d u' as (1, 0) (1 - F / z)^-1 (d + b / z), z = exp(2 pi i / steps)."""
        unit = ca.SX.eye(4)
        columns = [self.respond(unit[:2, k], unit[2, k], unit[3, k], ca.SX(wave.duration), p) for k in range(4)]
        f = ca.horzcat(*columns[:2])
        angle = 2 * ca.pi / wave.steps
        once, twice = ((ca.cos(n * angle), -ca.sin(n * angle)) for n in (1, 2))

        def sum_of(plain: ca.SX, by_one: ca.SX, by_two: ca.SX) -> tuple[ca.SX, ca.SX]:
            return plain + by_one * once[0] + by_two * twice[0], by_one * once[1] + by_two * twice[1]

        b, d = columns[2], columns[3]
        top = sum_of(d[0], b[0] - f[1, 1] * d[0] + f[0, 1] * d[1], f[0, 1] * b[1] - f[1, 1] * b[0])
        bottom = sum_of(ca.SX(1), -f[0, 0] - f[1, 1], f[0, 0] * f[1, 1] - f[0, 1] * f[1, 0])
        return wave.filtered(top, bottom)


def _fading(duration: ca.SX, p: Symbols) -> tuple[ca.SX, ca.SX, ca.SX]:
    """What is left of a deviation after a step, exp(M s) = own + ((along, across), (-across, -along)).

    With n = 2 / c: exp(-n s) (cosh x + sinh x / x s (M + n)), x^2 = n^2 (1 - c) s^2, which is negative where it rings.
    """
    s = ca.fmin(duration / (p.lag + INSTANT), FORGOTTEN)
    c = p.damping + SURE
    n = 2 / c
    square = n * n * (1 - c) * s * s
    x = ca.sqrt(ca.fmax(ca.fabs(square), 1.0))
    near, rings = ca.fabs(square) < 1, square < 0
    small = ca.if_else(near, square, 0.0)
    even, odd = (_series(small, k) for k in (0, 1))
    slow = ca.exp(-2 * s / (1 + ca.sqrt(ca.fmax(1 - c, SURE))))  # the slower of two real modes
    ringing, quick = ca.exp(-n * s), ca.exp(-2 * x)

    def of(series: ca.SX, swinging: ca.SX, creeping: ca.SX) -> ca.SX:
        return ca.if_else(near, ringing * series, ca.if_else(rings, ringing * swinging, slow * creeping))

    own = of(even, ca.cos(x), (1 + quick) / 2)
    left = s * of(odd, ca.sin(x) / x, (1 - quick) / (2 * x))
    return own, (n - 1) * left, left


def _series(square: ca.SX, first: int) -> ca.SX:
    """cosh x (first 0) or sinh x / x (1) of a small x^2; cosines and sines where that is negative."""
    found = ca.SX(0)
    for i in reversed(range(TERMS)):
        found = 1 / factorial(2 * i + first) + square * found
    return found


EFFECT = ServoInertia(
    name="servo_inertia",
    place=None,
    parameters=(
        Parameter("lag", "s", 0.0, 5.0, 0.0, 0.08, "2 damping / natural frequency [rad/s]"),
        Parameter("damping", "1", 0.05, float("inf"), None, 0.7, "ratio: below 1 it rings, far above it is a lag", -2),
    ),
    looks_like="every servo sets in softly, follows late and overshoots; at one quick pace waves come out largest",
    what_to_do="raise the servos' gain and its damping (D gain), lower the inertia that they move, or play more slowly",
    needs=frozenset({"servos"}),
    rank=0,
    memory=2,
    needs_seconds=True,
)
