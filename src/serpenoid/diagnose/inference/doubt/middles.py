"""Where the drag sits: where drag at vertices leaves more than chance, eps is fitted to drag amid the edges."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from serpenoid.diagnose.data.windows.windows import Track
from serpenoid.diagnose.inference.doubt.laws import misses
from serpenoid.diagnose.inference.fits.medium import fit_eps
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.diagnose.inference.search.tries import unclear
from serpenoid.model import Model


class Amid(NamedTuple):
    """How drag in the middles of edges does, in words, and what it misses windows by, over the noise."""

    words: str = ""
    misses: float = float("inf")


def drag_amid_edges(found: Selection, track: Callable[[Model], tuple[Track, ...]]) -> Amid:
    """Drag in the middles of edges beside drag at vertices; nothing where it is no question, or does worse, by eps
    alone, than what is named makes of drag at vertices.

    track: the recordings' tracks with a body that has vertices there, about a model of it.
    """
    model = found.null.model
    if not unclear(found.best) or model.effects or model.body.joint_count < model.body.vertices - 2:
        return Amid()
    amid = replace(model, body=model.body.with_middles())
    motion = replace(found.motion, tracks=track(amid))
    fitted = fit_eps(motion, amid)
    if fitted.evidence.count.sum() < found.best.evidence.count.sum():
        return Amid()
    ours = found.motion.tracks
    left, alone, best = misses(found.motion, [(motion.tracks, fitted), (ours, found.null), (ours, found.best)])
    if round(left, 1) >= round(min(alone, best), 1):  # as it would be said
        return Amid()
    with_named = ", with what is named," if found.best.effects and best < alone else ""
    words = (
        f"drag in the middles of edges misses windows by {left:.1f} times the noise, drag at vertices{with_named} by "
        f"{min(alone, best):.1f}"
    )
    return Amid(words, left)
