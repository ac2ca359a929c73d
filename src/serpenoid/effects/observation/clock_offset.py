"""Two clocks that do not run alike: servo time = (1 + rate) camera time + zero; unequal zeros are no effect."""

from __future__ import annotations

from dataclasses import replace

from serpenoid.effects.base import ObservationEffect, Parameter, Values
from serpenoid.effects.view import View


class ClockOffset(ObservationEffect):
    """The servo log drifts against the cameras."""

    def on_view(self, view: View, place: int | None, values: Values) -> View:
        """Stretch the servo's clock."""
        return replace(view, servo_times=(1 + values["rate"]) * view.servo_times)


EFFECT = ClockOffset(
    name="clock_offset",
    place=None,
    parameters=(Parameter("rate", "s/s", -0.5, 0.5, 0.0, 5e-3, "> 0: the servo's clock is fast", resolution=1e-5),),
    looks_like="shapes from the servo log run ahead of the cameras' more and more within a trial",
    what_to_do="use one clock, or a flash and a wink of a joint at both ends of a trial",
    needs=frozenset({"servos"}),
    reasons={"nlp": "clocks do not change how the body moves: the optimal gait is the same with and without it"},
    rank=4,
    marks="rate",
)
