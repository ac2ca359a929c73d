"""Play between a servo's horn and its link: the encoder follows the set-point, the link does so across a gap."""

from __future__ import annotations

from serpenoid.effects.actuation.backlash import Backlash
from serpenoid.effects.base import Parameter

EFFECT = Backlash(
    name="loose_joint",
    place="joint",
    parameters=(Parameter("width", "rad", 0.0, 3.0, 0.0, 0.05, "full width of the gap"),),
    looks_like="one link is late by the same angle at every speed; the markers show it and the servo log does not",
    what_to_do="tighten the horn's screw and the bracket; replace a worn horn",
    rank=6,
    memory=True,
    shown=False,
)
