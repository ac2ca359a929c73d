"""Play between a servo's horn and its link: the encoder follows the set-point, the link does so across a gap."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from serpenoid.effects.actuation import backlash

TICK = 2 * np.pi / 4096
GAP = replace(backlash.EFFECT.parameters[0], resolution=TICK / 4)  # jitter of readings crosses so much of a gap

EFFECT = replace(
    backlash.EFFECT,
    name="loose_joint",
    parameters=(GAP,),
    looks_like="one link is late by the same angle at every speed; the markers show it and the servo log does not",
    what_to_do="tighten the horn's screw and the bracket; replace a worn horn",
    rank=6,
    shown=False,
    marks="gaps",
)
