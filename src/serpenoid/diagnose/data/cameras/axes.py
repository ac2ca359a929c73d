"""Effects of observation that make distances depend on their direction on the floor: a linear map of all positions.

What they do is asked of their own law (`on_view`), on unit vectors. Legend: A coordinates, one for each parameter.
"""

from __future__ import annotations

import numpy as np

from serpenoid.body import Floats
from serpenoid.effects import active
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.catalogue import marking
from serpenoid.effects.view import View

UNIT = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
STEP = 1e-3


def resting() -> Floats:
    """The numbers (A,) of square axes of one scale."""
    return np.array([p.resting for kind in marking("axes") for p in kind.parameters])


def map_of(numbers: Floats) -> Floats:
    """What is seen of unit vectors, one a row (2, 2): seen = true @ map."""
    effects, begun = [], 0
    for kind in marking("axes"):
        end = begun + len(kind.parameters)
        effects.append(ActiveEffect.neutral(kind.name).with_coordinates(numbers[begun:end]))
        begun = end
    seen = active.seen(View.true(UNIT[None], np.zeros(1)), effects).markers[0]
    return np.asarray(seen[1:] - seen[0])


def slope(numbers: Floats, number: int) -> Floats:
    """Derivative of the map by one of the numbers, (2, 2)."""
    step = STEP * (np.arange(len(numbers)) == number)
    return (map_of(numbers + step) - map_of(numbers - step)) / (2 * STEP)
