"""Markers on a skin that slides over the joints: seen at p_k + share (p_(k-1) - 2 p_k + p_(k+1)), ends as they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from serpenoid.effects.base import ObservationEffect, Parameter, Values
from serpenoid.effects.view import View


class SlidingSkin(ObservationEffect):
    """Every marker cuts the corner between its neighbours."""

    def on_view(self, view: View, place: int | None, values: Values) -> View:
        """Move the inner markers."""
        markers = view.markers.copy()
        markers[:, 1:-1] += values["share"] * np.diff(view.markers, 2, axis=1)
        return replace(view, markers=markers)


EFFECT = SlidingSkin(
    name="sliding_skin",
    place=None,
    parameters=(Parameter("share", "1", -0.5, 0.5, 0.0, 0.02, "of the way to the middle of both neighbours, halved"),),
    looks_like="links look shorter where the body bends, and only there",
    what_to_do="glue the markers to the joints' axes",
    reasons={"nlp": "cameras do not change how the body moves: the optimal gait is the same with and without it"},
)
