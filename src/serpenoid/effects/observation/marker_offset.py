"""A marker that is not where it should be: seen at p + along E + left E_left, E the edge on its tail side."""

from __future__ import annotations

from serpenoid.effects.base import ObservationEffect, Parameter, Values
from serpenoid.effects.view import View


class MarkerOffset(ObservationEffect):
    """The marker moves with the link behind it."""

    def on_view(self, view: View, place: int | None, values: Values) -> View:
        """Move one marker."""
        vertex = place or 0
        return view.displaced(vertex, max(vertex - 1, 0), values["along"], values["left"])


EFFECT = MarkerOffset(
    name="marker_offset",
    place="vertex",
    parameters=(
        Parameter("along", "m", -0.2, 0.2, 0.0, 5e-3, "> 0: towards the head", resolution=2e-5),
        Parameter("left", "m", -0.2, 0.2, 0.0, 3e-3, "> 0: to the left", resolution=2e-5),
    ),
    looks_like="two neighbouring links seem to have wrong lengths, or their joints constant wrong angles",
    what_to_do="glue the marker over its axis, or enter where it sits; at an end of the body measure the edge first: "
    "a wrong length looks the same",
    reasons={"nlp": "cameras do not change how the body moves: the optimal gait is the same with and without it"},
    rank=0,
    marks="markers",
)
