"""A track that is lost and found elsewhere: after every gap of all markers the seen positions are displaced."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from serpenoid.effects.base import Advice, ObservationEffect, Parameter, Values
from serpenoid.effects.view import View


class PositionJumps(ObservationEffect):
    """By `size`, in a direction that nobody knows, adding up."""

    def on_view(self, view: View, place: int | None, values: Values) -> View:
        """Displace what follows each gap; the directions come with the view."""
        directions = np.stack([np.cos(view.directions), np.sin(view.directions)], -1)
        after = view.times[:, None] >= view.gaps[None]
        jumps = values["size"] * after.astype(float) @ directions
        return replace(view, markers=view.markers + jumps[:, None])


EFFECT = PositionJumps(
    name="position_jumps",
    place=None,
    parameters=(Parameter("size", "m", 0.0, 1.0, 0.0, 0.01, "length of each jump"),),
    looks_like="the path breaks where all markers were lost, and nowhere else",
    what_to_do="fit every stretch between gaps with a start of its own; add cameras",
    of_animals=Advice(
        looks_like="the path breaks where all points were lost, and nowhere else",
        what_to_do="track every stretch between gaps by itself",
    ),
    reasons={"nlp": "cameras do not change how the body moves: the optimal gait is the same with and without it"},
    rank=3,
    marks="jumps",
)
