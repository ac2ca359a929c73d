"""Groups on the stage of motion: what else could stand in the place of each chosen effect, the others kept.

A rival is fitted to the data together with eps and the kept effects. It belongs to the group if the data cannot exclude
it (chi squared within a band of the choice) and if it is not separable: S_ab, the path RMS between the predictions of
the choice and of the rival over the noise level, is below three. Candidates are scored linearly first; those that
could come close are fitted in full.

Probabilities share one among the choice, its rivals and none of them, as their posteriors do, the other effects kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.data.noise import strength
from serpenoid.diagnose.inference.finding import Rival, excludable
from serpenoid.diagnose.inference.medium import Fit
from serpenoid.diagnose.inference.patches import Ranked
from serpenoid.diagnose.inference.posterior import explained
from serpenoid.diagnose.inference.ranking import score, shortlist
from serpenoid.diagnose.inference.select import (
    FINALISTS,
    PROMISING,
    SCREENING,
    TO_THE_END,
    Selection,
    attempt,
    finished,
)
from serpenoid.effects.active import ActiveEffect
from serpenoid.parallel import in_processes

AT_MOST = 10  # full fits for each chosen effect


@dataclass(frozen=True)
class Swap:
    """A rival and the fit in which it stands in the place of a chosen effect."""

    rival: Rival
    fit: Fit


@dataclass(frozen=True)
class Group:
    """A chosen effect, its probability (None where there is no posterior), and what could stand in its place."""

    effect: ActiveEffect
    probability: float | None
    swaps: tuple[Swap, ...]


def groups(found: Selection) -> tuple[Group, ...]:
    """Of every chosen effect."""
    return tuple(_of(found, e, base) for e, base in zip(found.best.effects, found.bases, strict=True))


def swaps_of(found: Sequence[Group]) -> tuple[Swap, ...]:
    """All rivals, best fit first."""
    return tuple(sorted((s for g in found for s in g.swaps), key=lambda s: s.fit.chi2))


def _of(found: Selection, effect: ActiveEffect, base: Fit) -> Group:
    motion, best = found.motion, found.best
    size = float(best.evidence.count.sum())
    close = promising(score(motion, base).ranked, {e.key for e in best.effects})
    tries = in_processes([(attempt, (motion, base, e, x, SCREENING)) for e, _, x in close])
    tries = sorted(tries, key=lambda t: t.fit.chi2)[:FINALISTS]
    fits: dict[tuple[str, int | None], Fit] = {}
    for t in in_processes([(finished, (motion, base, t, TO_THE_END)) for t in tries]):
        if t.added.key not in fits or t.fit.chi2 < fits[t.added.key].chi2:
            fits[t.added.key] = t.fit
    chosen, *shares = probabilities(motion, [best, *fits.values()], base)
    swaps = []
    for (key, fit), share in zip(fits.items(), shares, strict=True):
        apart = strength(motion, best.predictions, fit.predictions) / found.noise_level_m
        rival = Rival(next(e for e in fit.effects if e.key == key), effect, apart, share)
        if not excludable(fit.chi2, best.chi2, size) and not rival.separable:
            swaps.append(Swap(rival, fit))
    return Group(effect, chosen, tuple(swaps))


def probabilities(motion: Motion, fits: Sequence[Fit], base: Fit) -> list[float | None]:
    """Of each fit, beside the others and `base`, every one under the discrepancy that is likeliest with it."""
    if motion.sizes is None:
        return [None] * len(fits)
    scores = np.array([e.score for e in in_processes([(explained, (motion, f, 0, 1)) for f in (*fits, base)])])
    weights = np.exp(scores - scores.max())
    return [float(w) for w in weights[:-1] / weights.sum()]


def promising(ranked: Sequence[Ranked], chosen: set[tuple[str, int | None]]) -> list[Ranked]:
    """Candidates other than the chosen whose first-order gain is a good share of the largest."""
    most = max((gain for _, gain, _ in ranked), default=0.0)
    return shortlist([r for r in ranked if r[0].key not in chosen and r[1] >= PROMISING * most], AT_MOST)
