"""A camera whose scale is another along x than along y, or whose axes are not square.

    seen = (1 + E) true,    2 E = longer (1 0, 0 -1) + shear (0 1, 1 0)

A link of heading phi looks longer by (longer cos 2 phi + shear sin 2 phi) / 2, as a share. What is alike in all
directions is `length_scale`; a turn of all changes no distance.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from serpenoid.effects.base import Advice, ObservationEffect, Parameter, Values
from serpenoid.effects.view import View


class CameraStretch(ObservationEffect):
    """Axes that were calibrated by one number, or pixels that are not square."""

    def on_view(self, view: View, place: int | None, values: Values) -> View:
        """Stretch all positions along one direction, and shrink them across."""
        longer, shear = values["longer"] / 2, values["shear"] / 2
        return replace(view, markers=view.markers @ np.array([[1 + longer, shear], [shear, 1 - longer]]))


EFFECT = CameraStretch(
    name="camera_stretch",
    place=None,
    parameters=(
        Parameter("longer", "1", -0.5, 0.5, 0.0, 0.01, "> 0: x looks longer than y, by this share", resolution=3e-5),
        Parameter(
            "shear", "rad", -0.5, 0.5, 0.0, 0.01,
            "> 0: 45 degrees from x towards y looks longer than across, as axes do that enclose less than 90 degrees",
            resolution=3e-5,
        ),
    ),
    looks_like="links are longer along one direction on the floor than across, and so are paths",
    what_to_do="calibrate the camera: the scale of each axis, and whether they are square (where one axis alone is "
    "wrong, `length_scale` is half as much)",
    of_animals=Advice(
        looks_like="the body is longer along one direction than across, and so are paths",
        what_to_do="calibrate the camera: the scale of each axis, and whether they are square",
    ),
    reasons={"nlp": "cameras do not change how the body moves: the optimal gait is the same with and without it"},
    rank=2,
    marks="axes",
)  # fmt: skip
