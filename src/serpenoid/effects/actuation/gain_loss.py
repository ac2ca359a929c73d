"""A joint that bends less than commanded: q = (1 - loss) q_set."""

from __future__ import annotations

import casadi as ca

from serpenoid.effects.base import ActuationEffect, Parameter, Symbols


class GainLoss(ActuationEffect):
    """A weak servo or a soft link."""

    def respond(self, angle: ca.SX, before: ca.SX, after: ca.SX, duration: ca.SX, p: Symbols) -> ca.SX:
        """Scale."""
        return (1 - p.loss) * after


EFFECT = GainLoss(
    name="gain_loss",
    place="joint",
    parameters=(Parameter("loss", "1", 0.0, 1.0, 0.0, 0.2, "share of the angle that is missing"),),
    looks_like="one joint's wave is smaller than commanded, in the same proportion in every gait",
    what_to_do="check that servo's supply and gains, or stiffen its bracket",
    needs=frozenset({"servos"}),
    rank=3,
)
