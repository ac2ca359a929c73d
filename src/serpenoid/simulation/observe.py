"""What cameras and clocks would report of a motion: the observation effects of a model, one after the other."""

from __future__ import annotations

from collections.abc import Sequence

from serpenoid.body import Floats
from serpenoid.effects.active import seen
from serpenoid.effects.view import View
from serpenoid.model import Model


def observe(
    model: Model, vertices_m: Floats, times: Floats, gaps: Sequence[float] = (), directions: Sequence[float] = ()
) -> View:
    """Markers (R, N, 2) [m] at camera times (R,) [s] as seen, and the same moments on the servos' clock.

    gaps: when each gap of all markers ends [s]; directions: where a jump across it goes [rad]. The result is linear in
    every parameter.
    """
    return seen(View.true(vertices_m, times, gaps, directions), model.observation_effects)
