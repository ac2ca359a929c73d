"""Play in one joint: it stays until the set-point has crossed the gap, then follows at half its width."""

from __future__ import annotations

import casadi as ca

from serpenoid.effects.base import ActuationEffect, Parameter, Symbols


class Backlash(ActuationEffect):
    """The play operator, exact at the ends of steps in which the set-point is monotone."""

    def respond(self, angle: ca.SX, before: ca.SX, after: ca.SX, duration: ca.SX, p: Symbols) -> ca.SX:
        """Stay, or be pushed."""
        half = p.width / 2
        return ca.fmin(ca.fmax(angle, after - half), after + half)


EFFECT = Backlash(
    name="backlash",
    place="joint",
    parameters=(Parameter("width", "rad", 0.0, 3.0, 0.0, 0.05, "full width of the gap"),),
    looks_like="one joint's wave has flat tops and is late by the same angle at every speed",
    what_to_do="replace the horn or its screw; preload the joint",
    reasons={
        "nlp": "where a joint stops and lets go again, the motion has kinks in the gait parameters: the optimality "
        "conditions, which use second derivatives, do not exist there. Simulate with it, optimise without it"
    },
    rank=2,
    memory=True,
)
