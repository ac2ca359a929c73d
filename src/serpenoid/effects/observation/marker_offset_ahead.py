"""A marker at a joint that rides on the link ahead: seen at p + along E + left E_left, E the edge on its head side."""

from __future__ import annotations

from serpenoid.body import Body
from serpenoid.effects.base import ObservationEffect, Values
from serpenoid.effects.observation import marker_offset
from serpenoid.effects.view import View


class MarkerOffsetAhead(ObservationEffect):
    """The marker moves with the link ahead of it."""

    def places(self, body: Body) -> list[int | None]:
        """Where two links meet; elsewhere the link ahead is the one behind."""
        return list(body.joint_vertices)

    def on_view(self, view: View, place: int | None, values: Values) -> View:
        """Move one marker."""
        vertex = place or 0
        return view.displaced(vertex, vertex, values["along"], values["left"])


EFFECT = MarkerOffsetAhead(
    name="marker_offset_ahead",
    place="vertex",
    parameters=marker_offset.EFFECT.parameters,
    looks_like="as `marker_offset`, but what is wrong turns with the link on the head side of the joint",
    what_to_do="glue the marker over its axis: it sits on the link ahead",
    reasons=marker_offset.EFFECT.reasons,
    rank=marker_offset.EFFECT.rank,
    marks="ahead",
)
