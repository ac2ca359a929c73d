"""What cameras and clocks would report of a motion: the observation effects of a model, one after the other."""

from __future__ import annotations

from collections.abc import Sequence

from serpenoid.body import Floats
from serpenoid.effects.base import ObservationEffect
from serpenoid.effects.catalogue import observation_effects
from serpenoid.effects.view import View
from serpenoid.model import Model


def observe(
    model: Model, vertices_m: Floats, times: Floats, gaps: Sequence[float] = (), directions: Sequence[float] = ()
) -> View:
    """Markers (R, N, 2) [m] at camera times (R,) [s] as seen, and the same moments on the servos' clock.

    gaps: when each gap of all markers ends [s]; directions: where a jump across it goes [rad]. The result is linear in
    every parameter.
    """
    view = View.true(vertices_m, times, gaps, directions)
    for kind in observation_effects():
        for active in model.observation_effects:
            if active.name == kind.name and isinstance(kind, ObservationEffect):
                view = kind.on_view(view, active.place, active.parameters)
    return view
