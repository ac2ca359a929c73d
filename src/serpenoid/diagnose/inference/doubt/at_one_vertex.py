"""A law of the whole body held against the same law at one vertex alone.

What pulls, rubs or slips at one vertex is no law of the whole body, and for lack of another one it takes that law's
name: a cable at one joint makes the floor seem to be a slope. The catalogue has no such law at a vertex, so it gets no
name; but where it would leave less than the law of the whole body does, this is a stand-in, and the vertex is said.

Both are judged to first order from the same fit without the law, so that they differ by nothing but where it acts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from serpenoid.diagnose.inference.fits.medium import linearised
from serpenoid.diagnose.inference.fits.prices import gained_by_chance
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import MediumEffect
from serpenoid.wording import listed


@dataclass(frozen=True)
class AtOneVertex:
    """A law of the whole body that would leave less at one vertex; share: of the chi squared that it leaves there."""

    effect: ActiveEffect
    vertex: int
    share: float


def words_of(found: Sequence[AtOneVertex]) -> tuple[str, ...]:
    """For people, vertex by vertex."""
    said = []
    for vertex in dict.fromkeys(a.vertex for a in found):
        laws = [f"{a.effect.name} {a.share:.0%}" for a in found if a.vertex == vertex]
        said.append(
            f"at vertex {vertex} alone less would be left ({listed(laws)} of what is left): what touches, pulls or "
            "carries the body there?"
        )
    return tuple(said)


def at_one_vertex(found: Selection) -> tuple[AtOneVertex, ...]:
    """Laws of the whole body that are named, and would leave less where they acted at one vertex alone."""
    better = (_at_one_vertex(found, index) for index in range(len(found.best.effects)))
    return tuple(b for b in better if b is not None)


def _at_one_vertex(found: Selection, index: int) -> AtOneVertex | None:
    """Of one of the effects, beside all others; the price is that of as many tries as there are vertices."""
    effect, base, motion = found.best.effects[index], found.bases[index], found.motion
    law, body = effect.effect, base.model.body
    if effect.place is not None or law.scan is not None or not isinstance(law, MediumEffect):
        return None
    vertices = [v for v in range(body.vertices) if law.is_present(v, body.vertices)]
    candidates = [ActiveEffect.neutral(law.name, place) for place in (None, *vertices)]
    evidence, _ = linearised(motion, base.model, base.effects, candidates, near=base.predictions)
    own, size = len(base.coordinates), len(law.parameters)

    def left(number: int) -> float:
        first = own + number * size
        return evidence.chi2([*range(own), *range(first, first + size)])

    whole = min(left(0), found.best.chi2)
    alone, vertex = min((left(1 + i), v) for i, v in enumerate(vertices))
    unit = max(1.0, alone / float(evidence.count.sum()))
    if whole - alone <= gained_by_chance(len(vertices)) * unit:
        return None
    return AtOneVertex(effect, vertex, alone / whole)
