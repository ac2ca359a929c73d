"""A wrong scale: seen position = (1 + error) times the true one."""

from __future__ import annotations

from dataclasses import replace

from serpenoid.effects.base import ObservationEffect, Parameter, Values
from serpenoid.effects.view import View


class LengthScale(ObservationEffect):
    """A calibration wand entered with a wrong length."""

    def on_view(self, view: View, place: int | None, values: Values) -> View:
        """Scale all positions."""
        return replace(view, markers=(1 + values["error"]) * view.markers)


EFFECT = LengthScale(
    name="length_scale",
    place=None,
    parameters=(Parameter("error", "1", -0.5, 0.5, 0.0, 0.01, "> 0: everything looks larger", resolution=3e-5),),
    looks_like="all links are too long or too short by the same share",
    what_to_do="calibrate the cameras again",
    reasons={"nlp": "cameras do not change how the body moves: the optimal gait is the same with and without it"},
    rank=2,
    marks="scale",
)
