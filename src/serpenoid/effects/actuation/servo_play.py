"""Play in all joints alike, of gears that are worn as all others or of a dead band that servos keep: the law of
`backlash` at every joint."""

from __future__ import annotations

from dataclasses import replace

from serpenoid.effects.actuation import backlash

EFFECT = replace(
    backlash.EFFECT,
    name="servo_play",
    place=None,
    looks_like="every joint's wave has flat tops and is late by the same angle at every speed",
    what_to_do="look at the servos' dead band (compliance margin) and gains; preload the joints, or renew worn gears",
)
