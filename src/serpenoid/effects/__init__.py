"""Physical effects beyond the baseline, one per file, at three sites: actuation, medium, observation."""

from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import ActuationEffect, Effect, MediumEffect, ObservationEffect, Parameter
from serpenoid.effects.catalogue import catalogue, find, places

__all__ = [
    "ActiveEffect",
    "ActuationEffect",
    "Effect",
    "MediumEffect",
    "ObservationEffect",
    "Parameter",
    "catalogue",
    "find",
    "places",
]
