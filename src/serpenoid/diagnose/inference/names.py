"""What is named of all that a search found: what earns its name and is visible.

An effect earns its name if, beside all others, it takes away more than the best of all candidates would take of what
is left if none of them were a cause (null.py), and if what it accounts for is no mere error of the law of the others
(discrepancy.py), and if its interval, which holds what gaits disagree about, leaves out the value that changes nothing.
All that is named together takes away more than it leaves. Its trace in the path must stand above the
noise level.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.data.paths import strength
from serpenoid.diagnose.inference.discrepancy import outdone
from serpenoid.diagnose.inference.medium import (
    TO_THE_END,
    Fit,
    fit_guided,
    fit_without,
    linearised,
    predicted_without,
)
from serpenoid.diagnose.inference.prices import least_idle, outweighed
from serpenoid.diagnose.inference.ranking import needed
from serpenoid.effects.active import ActiveEffect
from serpenoid.parallel import in_processes

NORMAL = 1.96  # standard deviations: 95 %


@dataclass(frozen=True)
class Try:
    """A full fit with one more (or another) effect."""

    fit: Fit
    added: ActiveEffect
    strength_m: float

    @property
    def fitted(self) -> ActiveEffect:
        """The added effect with its fitted values."""
        return next(e for e in self.fit.effects if e.key == self.added.key)


@dataclass(frozen=True)
class Undetected:
    """A try that gains but does not stand out, fitted on tracks made about it."""

    attempt: Try
    motion: Motion


@dataclass(frozen=True)
class Refused:
    """An effect of the search that is no cause, the share of chi squared that it would take away, the fit with it."""

    effect: ActiveEffect
    share: float
    fit: Fit


def kept(
    motion: Motion, null: Fit, best: Fit, noise_level_m: float, alone: float = 0.0
) -> tuple[Fit, tuple[Fit, ...], tuple[Undetected, ...], tuple[Refused, ...]]:
    """What is both earned and visible, the fits without each of it; what is not visible, what is not earned.

    Effects earn their names together, so those that stay must earn theirs without the ones that are not visible.
    alone: noise levels that an only effect must show; 0 where the search has judged it.
    """
    lost: tuple[Undetected, ...] = ()
    refused: tuple[Refused, ...] = ()
    while True:
        best, rest = earned(motion, null, best)
        best, bases, weak = visible(motion, null, best, noise_level_m, alone)
        lost, refused = (*weak, *lost), (*refused, *rest)
        if not weak:
            return best, bases, lost, refused


def earned(motion: Motion, null: Fit, best: Fit) -> tuple[Fit, tuple[Refused, ...]]:
    """Without effects that are no causes, what takes away least first."""
    refused: list[Refused] = []
    while best.effects:
        bases = bases_of(motion, null, best)
        most = np.inf if outweighed(null.priced, best.priced) else needed(motion, best)
        idle = least_idle(best.priced, [b.priced for b in bases], most, partial(causes, motion, best, bases))
        if idle is None:
            break
        base = bases[idle]
        refused.append(Refused(best.effects[idle], (base.chi2 - best.chi2) / base.chi2, best))
        best = fit_guided(motion, base, TO_THE_END)
    return best, tuple(refused)


def causes(motion: Motion, best: Fit, bases: Sequence[Fit], likely: Sequence[int]) -> set[int]:
    """Which effects, of some by index, are known to be there, and account for no mere error of the others' law."""
    sure = [i for i, known in enumerate(certain(motion, best)) if known and i in likely] if likely else []
    mended = outdone(motion, best, [bases[i] for i in sure])
    return {i for i, done in zip(sure, mended, strict=True) if not done}


def certain(motion: Motion, best: Fit) -> list[bool]:
    """Of each effect, whether a value lies farther from the one that changes nothing than its 95 % interval reaches."""
    evidence, _ = linearised(motion, best.model, best.effects, near=best.predictions, hold=False)
    spread = max(1.0, np.sqrt(best.chi2 / best.evidence.count.sum()))
    reach = NORMAL * np.sqrt(np.diag(evidence.covariance(range(len(best.coordinates)), spread)))
    resting = [np.nan if p.neutral is None else p.resting for e in best.effects for p in e.effect.parameters]
    apart = np.abs(best.coordinates[1:] - resting) > reach[1:]  # never of what has no such value
    ends = np.cumsum([len(e.effect.parameters) for e in best.effects])[:-1]
    return [bool(part.any()) for part in np.split(apart, ends)]


def visible(
    motion: Motion, null: Fit, best: Fit, noise_level_m: float, alone: float = 0.0
) -> tuple[Fit, tuple[Fit, ...], tuple[Undetected, ...]]:
    """Without effects whose trace the later ones took over, the weakest first; the fits without each of the others."""
    lost: list[Undetected] = []
    while True:
        effects = best.effects
        bases = bases_of(motion, null, best)
        traces = [trace(motion, best, b, e) for e, b in zip(effects, bases, strict=True)]
        if not effects or min(traces) >= noise_level_m * (1.0 if len(effects) > 1 else alone):
            return best, bases, tuple(lost[::-1])
        weakest = int(np.argmin(traces))
        lost.append(Undetected(Try(best, effects[weakest], traces[weakest]), motion))
        best = fit_guided(motion, bases[weakest], TO_THE_END)


def trace(motion: Motion, full: Fit, base: Fit, effect: ActiveEffect) -> float:
    """Path RMS [m] that `effect` of a fit is worth: against the fit without it.

    Where eps is known, and nearer to that with the effect, eps is not let run to take its place.
    """
    fitted_again = strength(motion, full.predictions, base.predictions)
    if motion.ratio is None:
        return fitted_again
    near, far = (abs(np.log(f.model.medium.anisotropy_ratio / motion.ratio)) for f in (full, base))
    if near >= far:
        return fitted_again
    return max(fitted_again, strength(motion, full.predictions, predicted_without(motion, full, effect)))


def each_without(motion: Motion, best: Fit) -> tuple[Fit, ...]:
    """Fits without each of the effects."""
    return tuple(in_processes([(fit_without, (motion, best, e)) for e in best.effects]))


def bases_of(motion: Motion, null: Fit, best: Fit) -> tuple[Fit, ...]:
    """The same; without an only effect that is eps alone."""
    return (null,) if len(best.effects) == 1 else each_without(motion, best)
