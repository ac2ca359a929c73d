"""One servo that cannot keep up: the law of `speed_saturation` at one joint."""

from __future__ import annotations

from dataclasses import replace

from serpenoid.effects.actuation import speed_saturation

EFFECT = replace(
    speed_saturation.EFFECT,
    name="slow_joint",
    place="joint",
    looks_like="one joint's wave is a triangle in quick cycles; slow cycles are unharmed",
    what_to_do="look at that servo's velocity limit and profile, its cable and its gear",
)
