"""Which numbers of an observation model are whose: one column for each parameter of each effect at each place.

Legend: N vertices, m joints.
"""

from __future__ import annotations

from serpenoid.body import Body
from serpenoid.diagnose.data.cameras import axes, views
from serpenoid.effects.base import Marks
from serpenoid.effects.catalogue import catalogue, find, places, view_effects


def sizes(joints: int, vertices: int) -> dict[Marks, int]:
    """How many numbers there are of each kind, in their order; those of the views come last."""
    own = len(axes.resting())
    return {"zeros": joints, "markers": 2 * vertices, "scale": 1, "gaps": joints, "ahead": 2 * joints, "axes": own}


def first_columns(body: Body) -> dict[Marks | None, int]:
    """First column of each kind of number; None: of the views."""
    first: dict[Marks | None, int] = {}
    end = 0
    for mark, size in sizes(body.joint_count, body.vertices).items():
        first[mark], end = end, end + size
    return {**first, None: end}


def columns_of(body: Body, name: str, place: int | None) -> list[int]:
    """Column numbers of an effect that marks the observation model."""
    effect = find(name)
    first, size = first_columns(body)[effect.marks], len(effect.parameters)
    if effect.marks is None:
        return [first + i for i in next(own for view, own in views.numbered(body) if view.key == (name, place))]
    first += size * places(effect, body).index(place)
    return list(range(first, first + size))


def column_count(body: Body) -> int:
    """Of all columns."""
    return first_columns(body)[None] + len(views.resting(body))


def all_keys(body: Body) -> list[tuple[str, int | None]]:
    """Name and place of every effect that moves markers against the servos' chain; fewest numbers first."""
    marked = [k for k in catalogue().values() if k.marks and k.marks in first_columns(body)]
    kinds = sorted((*marked, *view_effects()), key=lambda k: len(k.parameters))
    return [(kind.name, place) for kind in kinds for place in places(kind, body)]
