"""One servo that follows with a delay: the law of `servo_lag` at one joint."""

from __future__ import annotations

from dataclasses import replace

from serpenoid.effects.actuation import servo_lag

EFFECT = replace(
    servo_lag.EFFECT,
    name="lagging_joint",
    place="joint",
    looks_like="one joint's wave is smaller and later than commanded; quick cycles suffer most",
    what_to_do="compare that servo's gains, profile and firmware with the others'; look for grit in its gear",
)
