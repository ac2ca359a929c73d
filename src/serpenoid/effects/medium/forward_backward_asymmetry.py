"""Scales or ratchets: eps -> eps (1 - asymmetry sgn v_t); > 0 slides more easily head first."""

from __future__ import annotations

from dataclasses import replace

from serpenoid.effects.base import Advice, MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Drag, soft_sign


class ForwardBackwardAsymmetry(MediumEffect):
    """Rolling resistance that knows forward from backward."""

    def on_drag(self, drag: Drag, p: Symbols) -> Drag:
        """Scale the tangential part by the direction of sliding."""
        return replace(drag, tangential=drag.tangential * (1 - p.asymmetry * soft_sign(drag.forward)))


EFFECT = ForwardBackwardAsymmetry(
    name="forward_backward_asymmetry",
    place=None,
    parameters=(Parameter("asymmetry", "1", -1.0, 1.0, 0.0, 0.3, "> 0: easier head first"),),
    looks_like="head-first gaits go farther and tail-first gaits less far than predicted (or the reverse)",
    what_to_do="look for bent scales, ratcheting axles, or a nap of the carpet along the body",
    of_animals=Advice(
        looks_like="moves head first go farther and moves tail first less far than predicted (or the reverse)",
        what_to_do="expect it where scales or bristles lie along the skin",
    ),
    rank=30,
    knows=frozenset({"speed"}),
    scales_ratio=True,
    costly=True,
)
