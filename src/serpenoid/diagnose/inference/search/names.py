"""What is named of all that a search found: what earns its name and is visible.

An effect earns its name if, beside all others, it takes away more than the best of all candidates would take of what
is left if none of them were a cause (null.py), and more where repeats differ by more along it than windows say
(by_trial.py), and if what it accounts for is no mere error of the law of the others (discrepancy.py), and if its
interval, which holds what gaits disagree about, leaves out the value that changes nothing.
All that is named together takes away more than it leaves. Its trace in the path must stand above the
noise level.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from serpenoid.diagnose.data.chance import NORMAL
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.paths import path_error, path_noise, strength
from serpenoid.diagnose.inference.fits.finding import VISIBLE
from serpenoid.diagnose.inference.fits.medium import (
    TO_THE_END,
    Fit,
    fit_eps,
    fit_guided,
    fit_without,
    linearised,
    predicted_without,
)
from serpenoid.diagnose.inference.fits.prices import least_idle, outweighed
from serpenoid.diagnose.inference.search.by_trial import gained
from serpenoid.diagnose.inference.search.discrepancy import outdone
from serpenoid.diagnose.inference.search.ranking import needed
from serpenoid.effects.active import ActiveEffect, joined
from serpenoid.parallel import in_processes

Key = tuple[str, int | None]


@dataclass(frozen=True)
class Try:
    """A full fit with one more (or another) effect."""

    fit: Fit
    added: ActiveEffect

    @property
    def fitted(self) -> ActiveEffect:
        """The added effect with its fitted values."""
        return next(e for e in self.fit.effects if e.key == self.added.key)


@dataclass(frozen=True)
class Weak(Try):
    """One whose trace in the path is too weak to name it: path RMS [m]."""

    strength_m: float


@dataclass(frozen=True)
class Refused:
    """An effect of the search that is no cause, the share of chi squared that it would take away, the fit with it;
    beyond: at a bound of its own, beyond which the data push it."""

    effect: ActiveEffect
    share: float
    fit: Fit
    beyond: bool = False


@dataclass(frozen=True)
class Kept:
    """best: what is named; bases: it without each of its effects; settled: it with what is too weak to be named, one of
    which shifts what the other is taken for; undetected: what is too weak; refused: what is not earned."""

    best: Fit
    bases: tuple[Fit, ...]
    settled: Fit
    undetected: tuple[Weak, ...]
    refused: tuple[Refused, ...]


def kept(motion: Motion, null: Fit, best: Fit, noise_level_m: float, hidden: Collection[Key] = ()) -> Kept:
    """What is both earned and visible of a fit.

    hidden: what was not visible when it was found. It must be earned, too, and names are earned beside it: without it,
    what is left is an error of another kind, and the names may be bent around it. Names must be earned without those
    whose trace they took over.
    """
    lost: dict[Key, Weak] = {}
    best, refused = earned(motion, null, best)
    settled = best
    while True:
        shown, bases, weak = visible(motion, null, best, noise_level_m)
        lost |= {t.added.key: t for t in weak}
        overtaken = [t.added for t in weak if t.added.key not in hidden]
        if not overtaken:
            break
        best, rest = earned(motion, null, bare_of(motion, best, overtaken))
        refused = (*refused, *rest)
    there = {*lost, *(e.key for e in shown.effects)}
    settled = bare_of(motion, settled, [e for e in settled.effects if e.key not in there])
    return Kept(shown, bases, settled, tuple(lost.values()), refused)


def bare_of(motion: Motion, found: Fit, effects: Sequence[ActiveEffect]) -> Fit:
    """A fit without some of its effects."""
    for e in effects:
        found = fit_without(motion, found, e)
    return found


def earned(motion: Motion, null: Fit, best: Fit) -> tuple[Fit, tuple[Refused, ...]]:
    """Without effects that are no causes, what takes away least first."""
    refused: list[Refused] = []
    while best.effects:
        bases = bases_of(motion, null, best)
        most = np.inf if outweighed(null.priced, best.priced) else needed(motion, best)
        among = partial(causes, motion, best, bases)
        idle = least_idle(best.priced, [b.priced for b in bases], most, among, gained(motion, best))
        if idle is None:
            break
        base = bases[idle]
        refused.append(Refused(best.effects[idle], (base.chi2 - best.chi2) / base.chi2, best))
        best = fit_guided(motion, base, TO_THE_END)
    return best, tuple(refused)


def causes(motion: Motion, best: Fit, bases: Sequence[Fit], likely: Sequence[int]) -> set[int]:
    """Which effects, of some by index, are known to be there, and account for no mere error of the others' law."""
    sure = [i for i, known in enumerate(certain(motion, best, bases)) if known and i in likely] if likely else []
    mended = outdone(motion, best, [bases[i] for i in sure])
    return {i for i, done in zip(sure, mended, strict=True) if not done}


def certain(motion: Motion, best: Fit, bases: Sequence[Fit]) -> list[bool]:
    """Of each effect, whether gaits agree that it is there: what it takes away, over how much farther they scatter its
    value than curvature says, leaves nothing out of 95 % (Rotnitzky and Jewell, Biometrika 77, 485, 1990).

    Where chi squared is a parabola, its interval leaves out the value that changes nothing; a law that saturates is
    known to act where nobody can say how much. bases: fits without each.
    """
    evidence, _ = linearised(motion, best.model, best.effects, near=best.predictions, hold=False)
    spread = max(1.0, np.sqrt(best.chi2 / best.evidence.count.sum()))
    index = range(len(best.coordinates))
    wider = np.diag(evidence.covariance(index, spread)) / np.diag(evidence.solve(index)[1])
    parts = [wider[list(columns)].min() for columns in best.columns]
    return [bool(base.chi2 - best.chi2 > NORMAL**2 * part) for base, part in zip(bases, parts, strict=True)]


def visible(
    motion: Motion, null: Fit, best: Fit, noise_level_m: float
) -> tuple[Fit, tuple[Fit, ...], tuple[Weak, ...]]:
    """Without effects whose trace the later ones took over, the weakest first; the fits without each of the others."""
    lost: list[Weak] = []
    level = VISIBLE * noise_level_m
    while True:
        effects = best.effects
        bases = bases_of(motion, null, best)
        traces = in_processes([(seen, (motion, best, b, e, level)) for e, b in zip(effects, bases, strict=True)])
        if not effects or min(traces) >= level:
            return best, bases, tuple(lost[::-1])
        weakest = int(np.argmin(traces))
        lost.append(Weak(best, effects[weakest], traces[weakest]))
        best = fit_guided(motion, bases[weakest], TO_THE_END)


def seen(motion: Motion, full: Fit, base: Fit, effect: ActiveEffect, level: float) -> float:
    """Its trace; where that is below the noise level, what paths from the measured first poses are off by without it
    and not with it, if that is more than chance makes: an error of heading grows along them, which poses fitted anew
    hide."""
    own = trace(motion, full, base, effect)
    if own >= level:
        return own
    off = path_error(motion, base.predictions)
    if off <= path_noise(motion, base.predictions).farthest * level:
        return own
    return max(own, float(np.sqrt(max(off**2 - path_error(motion, full.predictions) ** 2, 0.0))))


def trace(motion: Motion, full: Fit, base: Fit, effect: ActiveEffect) -> float:
    """Path RMS [m] that `effect` of a fit is worth: against the fit without it.

    Where eps is known, and nearer to that with the effect, eps is not let run to take its place. Where windows show
    plainly that the others do not take its place, they are not let run to do so on the path.
    """
    fitted_again = strength(motion, full.predictions, base.predictions)
    if motion.ratio is None:
        return max(fitted_again, beside_the_others(motion, full, effect)) if plain(full, base) else fitted_again
    near, far = (abs(np.log(f.model.medium.anisotropy_ratio / motion.ratio)) for f in (full, base))
    if near >= far:
        return fitted_again
    return max(fitted_again, strength(motion, full.predictions, predicted_without(motion, full, effect)))


def plain(full: Fit, base: Fit) -> bool:
    """Whether windows without an effect are off by much more than chance, whatever others are there."""
    return bool(base.chi2 - full.chi2 > VISIBLE**2 * full.evidence.count.sum() and full.effects[1:])


def beside_the_others(motion: Motion, full: Fit, effect: ActiveEffect) -> float:
    """Path RMS [m] that an effect is worth with the others as they are, eps fitted again."""
    others = [e for e in full.effects if e.key != effect.key]
    bare = fit_eps(replace(motion, held=joined(motion.held, others)), full.model, full.predictions)
    return strength(motion, full.predictions, bare.predictions)


def each_without(motion: Motion, best: Fit) -> tuple[Fit, ...]:
    """Fits without each of the effects."""
    return tuple(in_processes([(fit_without, (motion, best, e)) for e in best.effects]))


def bases_of(motion: Motion, null: Fit, best: Fit) -> tuple[Fit, ...]:
    """The same; without an only effect that is eps alone."""
    return (null,) if len(best.effects) == 1 else each_without(motion, best)
