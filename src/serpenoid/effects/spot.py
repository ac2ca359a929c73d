"""A round spot on the floor: where it lies, how much of it a vertex feels, and where a diagnosis looks for it.

    felt = exp(-|p - (x, y)|^2 / (2 radius^2))

Effects that change something there, each in a file of its own, have a first parameter that says how much.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.base import Effect, Parameter, Symbols
from serpenoid.effects.element import Element
from serpenoid.effects.scan import Grid, Scan

RADII, MARGIN = (0.14, 0.24, 0.38), 0.27  # body lengths: sizes that are tried, and how far beyond the visited floor
AT_MOST = 300  # places along an axis: of a floor of 40 body lengths and more, every place is not tried


def spot(name: str, meaning: str) -> tuple[Parameter, ...]:
    """The parameters: how much changes in the middle, as a relative change, and where the spot lies."""
    return (
        Parameter(name, "1", -0.999, 20.0, 0.0, 2.0, meaning),
        Parameter("x", "m", -100.0, 100.0, None, 0.2, "middle of the patch on the floor"),
        Parameter("y", "m", -100.0, 100.0, None, 0.1, "middle of the patch on the floor"),
        Parameter("radius", "m", 0.01, 10.0, None, 0.2, "where it has fallen to 61 %"),
    )


def factor(element: Element, change: ca.SX, p: Symbols) -> ca.SX:
    """What is there over what is elsewhere, by the place of the vertex in the middle of the step."""
    away = element.place - ca.vertcat(p.x, p.y)
    return 1 + change * ca.exp(-ca.dot(away, away) / (2 * p.radius**2))


def scan(made_of: Effect, by_weight: bool) -> Scan:
    """How it is looked for, if to first order it is made of an effect that sits at vertices (see `Scan`)."""
    return Scan(made_of=made_of.name, by_weight=by_weight, size="radius", begins=(-0.9, 3.0), grids=grids)


def grids(low: Floats, high: Floats, length: float) -> list[Grid]:
    """Spots over a piece of floor, a radius apart."""
    low, high = low - MARGIN * length, high + MARGIN * length
    return [grid(length * radius, low, high) for radius in RADII]


def grid(radius: float, low: Floats, high: Floats) -> Grid:
    """Of one radius [m]: what is felt is a product of one of x and one of y."""
    counts = np.clip(np.ceil((high - low) / radius), 2, AT_MOST).astype(int)
    x, y = (np.linspace(low[i], high[i], counts[i]) for i in range(2))

    def felt(places: Floats) -> tuple[Floats, Floats]:
        away = places[..., :1] - x, places[..., 1:] - y
        return np.exp(-(away[0] ** 2) / (2 * radius**2)), np.exp(-(away[1] ** 2) / (2 * radius**2))

    return Grid(tuple({"x": float(a), "y": float(b), "radius": radius} for a in x for b in y), felt)
