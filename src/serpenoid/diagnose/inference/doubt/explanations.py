"""The change and what explains the reference, together: a name is held against names beside other explanations.

    L = w exp(-(D - least D) G / 2 N)

w: of an explanation, the inverse of what it left of the earlier campaign; D, N: deviance of the change beside it and
the number of means (discrepancy.py); G gaits, the independent numbers of a law's error (law_doubt.py). A law that was
fitted to one motion errs about another: a body that stood still while it rested says nothing of how it slides, and what
stands in for the floor's law may forbid it. A frame that moves is seen as it moves, on every floor: what a floor's law
gets wrong is in proportion to what acts by that law, and is no excuse for what is left beside a frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.inference.doubt.together import laws_of_the_body
from serpenoid.diagnose.inference.fits.medium import TO_THE_END, Fit, fit, fit_eps
from serpenoid.diagnose.inference.fits.rules import choose
from serpenoid.diagnose.inference.search.discrepancy import deviance
from serpenoid.diagnose.inference.search.names import Try
from serpenoid.diagnose.inference.search.ranking import score, shortlist
from serpenoid.diagnose.inference.search.select import SHARE, Selection
from serpenoid.diagnose.inference.search.tries import FULL_FITS, attempts
from serpenoid.effects.active import ActiveEffect
from serpenoid.model import Model
from serpenoid.parallel import in_processes

Beside = tuple[Motion, Model, float]  # tracks beside an explanation, its model, its weight


@dataclass(frozen=True)
class Likely:
    """What a change leaves beside an explanation: its weight, deviance for each mean, over 2, gait by gait."""

    weight: float
    left: float

    def over(self, other: Likely) -> float:
        """How many times as likely as another."""
        return self.weight / other.weight * float(np.exp(min(other.left - self.left, 700.0)))


def likely(motion: Motion, found: Fit, weight: float) -> Likely:
    """Of a fit to a motion beside an explanation."""
    seen = [e for e in found.effects if not acts(e)]
    deviated, count = deviance(motion, found, seen)
    return Likely(weight, deviated / max(count, 1) * len(set(motion.labels)) / 2)


def chance_alone(motion: Motion, weight: float) -> Likely:
    """Of a fit beside an explanation that leaves nothing else."""
    return Likely(weight, len(set(motion.labels)) / 2)


def acts(effect: ActiveEffect) -> bool:
    """Whether it changes how the body moves, not how that is seen."""
    return effect.effect.site == "medium"


def another(found: Selection, several: Sequence[Beside]) -> int | None:
    """Which explanation has beside it the likeliest single change, if that was not found beside the selection's own,
    the first of several, or is likelier than all that was."""
    own, whole = {e.name for e in found.best.effects}, likely(found.motion, found.best, several[0][2])
    tries = [(i, t, likely(m, t.fit, w)) for i, (m, model, w) in enumerate(several) for t in singles(m, model)]
    index, most = min(((i, how) for i, _, how in tries), key=lambda o: _unlikely(o[1]), default=(0, whole))
    if index and most.over(whole) > 1:
        return index
    named = [how for _, t, how in tries if t.added.name in own]
    others = [(i, how) for i, t, how in tries if t.added.name not in own]
    if not named or not others:
        return None
    index, most = min(others, key=lambda o: _unlikely(o[1]))
    return index if index and most.over(min(named, key=_unlikely)) > 1 else None


def singles(motion: Motion, model: Model) -> list[Try]:
    """The best fits with one effect beside an explanation."""
    base = fit_eps(motion, model)
    ranked = score(motion, base)
    promising = [r for r in ranked if r[1] > max(SHARE * ranked[0][1], 0.0)]
    return attempts(motion, base, shortlist(promising, FULL_FITS[0])) if promising else []


def _unlikely(how: Likely) -> float:
    return how.left - float(np.log(how.weight))


def laws(found: Selection) -> list[Fit]:
    """Every law of the body's own that explains alone what eps does not, for its price."""
    motion, null = found.motion, found.null
    whole = laws_of_the_body(motion, null)
    starts = [np.concatenate([null.coordinates, c.coordinates[:-1]]) for c in whole]
    fits = in_processes([(fit, (motion, null.model, [c], x, TO_THE_END)) for c, x in zip(whole, starts, strict=True)])
    return [f for f in fits if choose(null, [f], len(whole)) is not None]
