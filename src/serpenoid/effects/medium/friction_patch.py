"""A spot on the floor with other friction: F -> F (1 + strength exp(-|p - (x, y)|^2 / (2 radius^2)))."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.base import Advice, MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Element
from serpenoid.effects.medium import load
from serpenoid.effects.scan import Grid, Scan

RADII, MARGIN = (0.14, 0.24, 0.38), 0.27  # body lengths: sizes that are tried, and how far beyond the visited floor
AT_MOST = 300  # places along an axis: of a floor of 40 body lengths and more, every place is not tried


class FrictionPatch(MediumEffect):
    """A wet, dusty or rough place."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Scale the grip by the place of the vertex in the middle of the step."""
        away = element.place - ca.vertcat(p.x, p.y)
        factor = 1 + p.strength * ca.exp(-ca.dot(away, away) / (2 * p.radius**2))
        return replace(element, grip=element.grip * factor)


def grids(low: Floats, high: Floats, length: float) -> list[Grid]:
    """Patches over a piece of floor, a radius apart."""
    low, high = low - MARGIN * length, high + MARGIN * length
    return [grid(length * radius, low, high) for radius in RADII]


def grid(radius: float, low: Floats, high: Floats) -> Grid:
    """Of one radius [m]: exp(-|p - (x, y)|^2 / (2 radius^2)) is a product of one of x and one of y."""
    counts = np.clip(np.ceil((high - low) / radius), 2, AT_MOST).astype(int)
    x, y = (np.linspace(low[i], high[i], counts[i]) for i in range(2))

    def felt(places: Floats) -> tuple[Floats, Floats]:
        away = places[..., :1] - x, places[..., 1:] - y
        return np.exp(-(away[0] ** 2) / (2 * radius**2)), np.exp(-(away[1] ** 2) / (2 * radius**2))

    return Grid(tuple({"x": float(a), "y": float(b), "radius": radius} for a in x for b in y), felt)


EFFECT = FrictionPatch(
    name="friction_patch",
    place=None,
    parameters=(
        Parameter("strength", "1", -0.999, 20.0, 0.0, 2.0, "relative change of friction in the middle"),
        Parameter("x", "m", -100.0, 100.0, None, 0.2, "middle of the patch on the floor"),
        Parameter("y", "m", -100.0, 100.0, None, 0.1, "middle of the patch on the floor"),
        Parameter("radius", "m", 0.01, 10.0, None, 0.2, "where it has fallen to 61 %"),
    ),
    looks_like="residuals gather at one place on the floor, whichever vertex is there",
    what_to_do="clean the floor there, or move the arena",
    needs=frozenset({"ground"}),
    of_animals=Advice(
        looks_like="residuals gather at one place on the ground, whichever part of the body is there",
        what_to_do="look at the ground there: moisture, food, a scratch",
    ),
    rank=25,
    knows=frozenset({"place"}),
    scan=Scan(made_of=load.EFFECT.name, size="radius", begins=(-0.9, 3.0), grids=grids),
)
