"""A camera frame that turns about the room's origin: seen position = true position turned by rate t."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from serpenoid.effects.base import ObservationEffect, Parameter, Values
from serpenoid.effects.view import View
from serpenoid.group import rotation


class TurningFrame(ObservationEffect):
    """From the start of every trial."""

    def on_view(self, view: View, place: int | None, values: Values) -> View:
        """Turn all markers with time."""
        turns = rotation(values["rate"] * np.maximum(view.times, 0))
        return replace(view, markers=np.einsum("fij,fkj->fki", turns, view.markers))


EFFECT = TurningFrame(
    name="turning_frame",
    place=None,
    parameters=(Parameter("rate", "rad/s", -0.1, 0.1, 0.0, 1e-3, "to the left"),),
    looks_like="everything turns slowly the same way, in pauses too",
    what_to_do="tighten the cameras' mount",
    reasons={"nlp": "cameras do not change how the body moves: the optimal gait is the same with and without it"},
    marks="frame",
)
