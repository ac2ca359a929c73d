"""A marker that sways with the bend: seen at p + sway bend N, N to the left of the middle between both links.

At an end of the body it is the bend of the joint next to it, and N is to the left of its only link.
"""

from __future__ import annotations

import numpy as np

from serpenoid.body import Body
from serpenoid.effects.base import ObservationEffect, Parameter, Values
from serpenoid.effects.view import View, left_of


class MarkerSway(ObservationEffect):
    """The marker moves sideways in proportion to how far its joint is bent."""

    def places(self, body: Body) -> list[int | None]:
        """At joints, and at ends that are next to one."""
        joints, last = body.joint_vertices, body.vertices - 1
        return [
            v for v in range(last + 1) if v in joints or (v == 0 and 1 in joints) or (v == last and last - 1 in joints)
        ]

    def on_view(self, view: View, place: int | None, values: Values) -> View:
        """Move one marker."""
        vertex, last = place or 0, view.vertices.shape[1] - 1
        joint = min(max(vertex, 1), last - 1)
        behind, ahead = view.direction(joint - 1), view.direction(joint)
        bend = np.arctan2((left_of(behind) * ahead).sum(axis=-1), (behind * ahead).sum(axis=-1))[:, None]
        middle = behind * (vertex < last) + ahead * (vertex > 0)
        middle /= np.linalg.norm(middle, axis=-1, keepdims=True)
        return view.moved(vertex, values["sway"] * bend * left_of(middle))


EFFECT = MarkerSway(
    name="marker_sway",
    place="vertex",
    parameters=(
        Parameter("sway", "m/rad", -0.2, 0.2, 0.0, 5e-3, "> 0: to the side to which the joint bends", resolution=2e-5),
    ),
    looks_like="the marker is beside its place in proportion to how far its joint is bent (a post tilts, or tape gives "
    "way); at an end of the body as if the joint next to it bent farther than its servo reads",
    what_to_do="shorten the marker's post or make it stiff, and glue the marker over its axis",
    reasons={"nlp": "cameras do not change how the body moves: the optimal gait is the same with and without it"},
    rank=0,
)
