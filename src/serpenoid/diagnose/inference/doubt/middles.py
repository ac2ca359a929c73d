"""Where the drag sits: where drag at vertices leaves more than chance, drag elsewhere on the body is fitted, too.

It may act in the middles of edges, as under wheels there, or all along the links, as under a smooth body: in the
middles of PIECES of each edge (of what a rigid link resists turning by, 1 / PIECES^2 is left out). Which law it follows
is asked there as at vertices: dry friction of a whole link is another than that of its ends.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.windows.windows import Track
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR
from serpenoid.diagnose.inference.doubt.laws import beyond_chance, by_its_own_numbers, misses, on_rival
from serpenoid.diagnose.inference.fits.medium import Fit, fit_eps
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.diagnose.inference.search.tries import unclear
from serpenoid.media import Law, rivals
from serpenoid.model import Model

PIECES = 4
Tracked = Callable[[Model, int], tuple[Track, ...]]


class Elsewhere(NamedTuple):
    """How drag elsewhere does, in words, what it misses windows by, over the noise, and its model."""

    words: str = ""
    misses: float = float("inf")
    model: Model | None = None


def drag_elsewhere(found: Selection, track: Tracked, law_open: bool, without: Collection[str]) -> Elsewhere:
    """The place, and the law there, that leaves least beside drag at vertices; nothing where it is no question, or does
    worse, by itself, than what is named makes of drag at vertices. Other laws are asked for as long as the law leaves
    more than LAW_ERROR of what it does at vertices.

    track: the recordings' tracks about a model of a body that has vertices amid so many pieces of each edge. law_open:
    whether no file says which law it is; without: names of effects that are no numbers of one.
    """
    model = found.null.model
    if not unclear(found.best) or model.effects or model.body.joint_count < model.body.vertices - 2:
        return Elsewhere()
    ours = found.motion.tracks
    places = list(_places(found, track))
    best, alone = Elsewhere(), float("inf")
    for law in (model.law, *(rivals(model.law) if law_open else ())):
        if law is not model.law and beyond_chance(best.misses) < LAW_ERROR * beyond_chance(alone):
            break
        for place in places:
            fitted = place.fitted(law, without)
            if fitted is None or fitted.evidence.count.sum() < found.best.evidence.count.sum():
                continue
            several = [(place.motion.tracks, fitted), (ours, found.null), (ours, found.best)]
            left, alone, named = misses(found.motion, several)
            if round(left, 1) < round(min(alone, named, best.misses), 1):  # as it would be said
                with_named = ", with what is named," if found.best.effects and named < alone else ""
                words = f"{place.said(law)} misses windows by {left:.1f} times the noise, {place.here(law)}{with_named}"
                best = Elsewhere(f"{words} by {min(alone, named):.1f}", left, fitted.model)
    return best


@dataclass(frozen=True)
class Place:
    """Drag amid so many pieces of each edge: a model of the body that has vertices there, and the motion on it."""

    pieces: int
    model: Model
    motion: Motion

    def fitted(self, law: Law, without: Collection[str]) -> Fit | None:
        """A law with its own numbers; None where it is no question, or has no root."""
        if law is self.model.law:
            return fit_eps(self.motion, self.model)
        other = on_rival(self.model, law)
        if other is None:
            return None
        return by_its_own_numbers(self.motion, other, self.model.medium.anisotropy_ratio, without)

    def said(self, law: Law) -> str:
        """What acts where."""
        where = "in the middles of edges" if self.pieces == 1 else "all along the links"
        return f"drag {where}" if law is self.model.law else f"{law.title}, {where},"

    def here(self, law: Law) -> str:
        """What it is compared with."""
        return f"{'drag' if law is self.model.law else self.model.law.title} at vertices"


def _places(found: Selection, track: Tracked) -> Iterator[Place]:
    """Where drag may act: wheels are at one place of a link."""
    model = found.null.model
    for pieces in (1,) if model.body.kind == "wheeled robot" else (1, PIECES):
        amid = replace(model, body=model.body.with_middles(pieces))
        yield Place(pieces, amid, replace(found.motion, tracks=track(amid, pieces)))
