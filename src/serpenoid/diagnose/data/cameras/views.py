"""Effects of observation that are none of the known marks: what they show of the body, by their own law alone.

They know neither the time nor the room, and what is seen is linear in their parameters. Legend: F frames, N vertices.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from serpenoid.body import Body, Floats
from serpenoid.effects import active
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.catalogue import places, view_effects
from serpenoid.effects.view import View


def numbered(body: Body) -> list[tuple[ActiveEffect, range]]:
    """Each at every place, neutral, and which numbers are its coordinates."""
    found, end = [], 0
    for kind in view_effects():
        for place in places(kind, body):
            first, end = end, end + len(kind.parameters)
            found.append((ActiveEffect.neutral(kind.name, place), range(first, end)))
    return found


def resting(body: Body) -> Floats:
    """The numbers (V,) of effects that change nothing."""
    return np.array([x for view, _ in numbered(body) for x in view.coordinates[:-1]])


def seen(body: Body, markers: Floats, points: Floats, numbers: Floats) -> Floats:
    """Markers (F, N, 2) of a body at `points`, as effects with the coordinates `numbers` (V,) show them."""
    there = [(view, numbers[list(own)].tolist()) for view, own in numbered(body)]
    changed = [view.with_coordinates(now) for view, now in there if now != list(view.coordinates[:-1])]
    return _through(markers, points, changed)


def derivative(body: Body, points: Floats, number: int) -> Floats:
    """Of what is seen by one of the numbers, (F, N, 2)."""
    view, own = next((view, own) for view, own in numbered(body) if number in own)
    i = number - own.start
    p = view.effect.parameters[i]
    step = p.coordinate(p.typical) - view.coordinates[i]
    return (_through(points, points, [view.moved(i, step)]) - _through(points, points, [view])) / step


def _through(markers: Floats, points: Floats, views: list[ActiveEffect]) -> Floats:
    there = replace(View.true(points, np.zeros(len(points))), markers=markers)
    return active.seen(there, views).markers if views else markers
