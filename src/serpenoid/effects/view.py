"""What cameras and clocks report of a motion: the thing that observation effects transform. SI, by numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats


@dataclass(frozen=True)
class View:
    """markers (R, N, 2) [m] at camera times (R,) [s since the start]; servo_times (R,): the same moments on its clock.

    gaps (G,) [s]: when each gap of all markers ends; directions (G,) [rad]: where a jump across it would go.
    """

    markers: Floats
    times: Floats
    servo_times: Floats
    gaps: Floats
    directions: Floats

    @classmethod
    def true(
        cls, vertices: Floats, times: Floats, gaps: Sequence[float] = (), directions: Sequence[float] = ()
    ) -> View:
        """Without any effect."""
        times = np.asarray(times, float)
        return cls(np.asarray(vertices, float), times, times, np.asarray(gaps, float), np.asarray(directions, float))
