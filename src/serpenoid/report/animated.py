"""Bodies on the floor at a few moments, as a page's animation takes them: small enough to mail, whatever there is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from serpenoid.body import Floats

MOST_FRAMES = 160  # of one trial: smooth enough to scrub
ALL_FRAMES = 3200  # of a page: a megabyte or two


@dataclass(frozen=True)
class Layer:
    """One drawing of the body: vertices (R, N, 2) and centroid (R, 2) [body lengths]; width of its line in points."""

    label: str
    colour: str
    width: float
    bodies: Floats
    path: Floats


@dataclass(frozen=True)
class Animated:
    """One trial: time (R,) [s], and its layers by name, the first at the bottom."""

    name: str
    time: Floats
    layers: dict[str, Layer]

    def data(self, frames: int) -> dict[str, Any]:
        """At up to `frames` moments, rounded to a tenth of a thousandth of a body length."""
        rows = np.unique(np.linspace(0, len(self.time) - 1, frames).round().astype(int))
        return {
            "name": self.name,
            "time": (self.time[rows] - self.time[0]).round(3).tolist(),
            "classes": {
                name: {
                    "label": layer.label, "colour": layer.colour, "width": layer.width,
                    "bodies": layer.bodies[rows].round(4).tolist(), "path": layer.path[rows].round(4).tolist(),
                }
                for name, layer in self.layers.items()
            },
        }  # fmt: skip


def animation_data(trials: Sequence[Animated]) -> list[dict[str, Any]]:
    """Every trial; the more there are, the fewer moments of each."""
    frames = min(MOST_FRAMES, max(2, ALL_FRAMES // max(len(trials), 1)))
    return [trial.data(frames) for trial in trials]
