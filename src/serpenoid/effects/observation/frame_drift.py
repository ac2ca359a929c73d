"""A camera frame that creeps: seen position = true position + velocity t.

Water or wind that carries the body steadily shows exactly so, with the velocity of the flow.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from serpenoid.effects.base import Advice, ObservationEffect, Parameter, Values
from serpenoid.effects.view import View


class FrameDrift(ObservationEffect):
    """From the start of every trial."""

    def on_view(self, view: View, place: int | None, values: Values) -> View:
        """Shift all markers with time."""
        velocity = np.array([values["velocity_x"], values["velocity_y"]])
        moved = view.markers + np.maximum(view.times, 0)[:, None, None] * velocity
        return replace(view, markers=moved)


EFFECT = FrameDrift(
    name="frame_drift",
    place=None,
    parameters=(
        Parameter("velocity_x", "m/s", -0.1, 0.1, 0.0, 1e-3, "along the floor's x"),
        Parameter("velocity_y", "m/s", -0.1, 0.1, 0.0, 1e-3, "along the floor's y"),
    ),
    looks_like="everything moves slowly the same way, in pauses too and whatever the body's heading: the cameras' "
    "frame creeps, or water or wind that moves carries the body",
    what_to_do="film markers fixed to the floor: if they stay, water or wind moves, by this velocity; if they creep, "
    "too, calibrate again with warm cameras",
    of_animals=Advice(
        looks_like="everything moves slowly the same way, whatever the body's heading, and while it rests",
        what_to_do="look for flow, a stage that creeps, or a camera that warms up",
    ),
    reasons={"nlp": "cameras do not change how the body moves: the optimal gait is the same with and without it"},
    rank=1,
    marks="frame",
)
