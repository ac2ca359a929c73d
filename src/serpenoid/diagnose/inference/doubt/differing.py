"""Are all parts of a kind a little different? No two wheels roll alike, and no two links weigh the same.

An effect at a place says that one part is different, one of the whole body that all parts are alike. Where all differ a
little, the few that differ most are named and stand for the others, or one of the whole body does. So beside what is
named, all places of a kind that have no name are drawn:

    theta_k ~ N(0, t)

eps takes what they have in common; a wheel that rolls better than most has a seizure below zero. t is what makes the
campaign most likely (variance components: Harville, J. Am. Stat. Assoc. 72, 320, 1977). What named values scatter by
beside it goes into their intervals. A name of the floor must be worth its price beside it, too (prices.py): else it is
a stand-in, parts that differ do as well.

Legend: P columns (eps first), K places without a name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from serpenoid.body import Body, Floats
from serpenoid.diagnose.data.chance import CONFIDENCE, ERROR, NORMAL
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.paths import strength
from serpenoid.diagnose.data.noise.shared import discrepancy
from serpenoid.diagnose.data.windows.windows import Prediction
from serpenoid.diagnose.inference.doubt.law_doubt import Coordinate, Doubted
from serpenoid.diagnose.inference.fits.bounds import at_values
from serpenoid.diagnose.inference.fits.evidence import SILENT, Evidence, inverted
from serpenoid.diagnose.inference.fits.finding import VISIBLE
from serpenoid.diagnose.inference.fits.medium import Fit, candidates_of, coordinates_of, linearised, with_values
from serpenoid.diagnose.inference.fits.prices import gained_by_chance
from serpenoid.diagnose.inference.search.names import Key
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import MediumEffect
from serpenoid.effects.catalogue import find, medium_effects, places
from serpenoid.model import Model

ROUNDS = 6
SETTLED = 0.1  # of -2 ln likelihood
TINY = 1e-12  # beside nothing: an effect at its neutral value is none of a model
DRAWS = 2000
SIZES = np.exp(np.arange(-24.0, 6.0, 0.25))  # t, in squares of what the data tell of a place


@dataclass(frozen=True)
class Differing:
    """Parts of a kind, an effect's name, that differ by more than chance makes it seem.

    size: SD of its parameter; ratio, doubt: eps and what is settled on beside them; predictions: with them. as_well:
    names that parts which differ do without; told: whether paths show it, or a name is in doubt for it.
    """

    kind: str
    size: float
    ratio: Doubted
    doubt: Mapping[Coordinate, Doubted]
    predictions: Sequence[Prediction]
    as_well: frozenset[Key] = frozenset()
    told: bool = False

    @property
    def words(self) -> str:
        """What is left, and what it may stand for."""
        names = ", ".join(ActiveEffect.neutral(*key).called for key in sorted(self.as_well, key=str))
        place = find(self.kind).place
        instead = f"; that explains as much without {names}" if names else ""
        return f"the parts are not alike: {self.kind} varies by {self.size:.2g} (SD) from {place} to {place}{instead}"


def differing(found: Selection, inadequate: bool = False) -> Differing | None:
    """The kind of which that is likeliest beside what is settled on; None: no parts differ by more than chance, or what
    is left repeats with them, too: then they are not what is missing.

    With a reference parts differ as they did then. inadequate: the law is known to be another.
    """
    motion, settled = found.motion, found.settled
    if motion.ratio is not None or inadequate:
        return None
    kinds = [k for k in medium_effects() if _all_over(k, motion, settled)]
    several = [_beside(motion, settled, _unnamed(settled, k)) for k in kinds]
    best = max(several, key=lambda d: d.gained, default=None)
    if best is None or best.gained <= best.by_chance((1 - CONFIDENCE) / len(several)):
        return None
    every = _settled(motion, best)
    if discrepancy(motion, every.predictions) > 0:
        return None
    sure = best.gained > best.by_chance(ERROR / len(several))
    return _beside_names(found, kinds[several.index(best)], every, sure)


def _beside_names(found: Selection, kind: MediumEffect, every: _Drawn, sure: bool) -> Differing:
    """The same beside what is named and without each name of another kind; sure: whether parts are known to differ
    beside what is named."""
    motion, settled = found.motion, found.settled
    tries = len(candidates_of(settled))
    doubt, as_well, size = _doubt(every, settled), set(), every.size
    for e in found.best.effects:
        if e.effect.site != "medium":
            continue
        if _idle(motion, e, doubt):
            as_well.add(e.key)
        elif e.name != kind.name:
            rest = _settled(motion, _without(motion, every, e))
            toll = len(e.effect.parameters) * float(np.log(settled.evidence.count.sum())) + gained_by_chance(tries)
            if rest.deviance - every.deviance <= toll * every.spread:
                as_well.add(e.key)
                size = max(size, rest.size)
    seen = sure and strength(motion, every.predictions, settled.predictions) >= VISIBLE * found.noise_level_m
    ratio = Doubted(float(every.likeliest[0]), float(every.deviations[0]))
    return Differing(kind.name, size, ratio, doubt, every.predictions, frozenset(as_well), seen or bool(as_well))


def _idle(motion: Motion, effect: ActiveEffect, doubt: Mapping[Coordinate, Doubted]) -> bool:
    """Whether the intervals of all of its parameters hold what changes nothing."""
    known = [(x, doubt[effect.name, effect.place, i]) for i, x in enumerate(motion.unchanged(effect))]
    return all(abs(d.value - resting) <= NORMAL * d.deviation for resting, d in known)


def _all_over(kind: MediumEffect, motion: Motion, found: Fit) -> bool:
    """Whether an effect sits at one vertex or another, has one number, and may be there."""
    alone = kind.place == "vertex" and len(kind.parameters) == 1 and kind.parameters[0].neutral is not None
    offered = kind.name not in motion.untestable and kind.acts_in(found.model.medium.law)
    return alone and offered and len(_unnamed(found, kind)) > 2


def _unnamed(found: Fit, kind: MediumEffect) -> list[ActiveEffect]:
    """Parts of a kind that a fit has no effect at."""
    there = {e.key for e in found.model.effects}
    every = [ActiveEffect.neutral(kind.name, place) for place in places(kind, found.model.body)]
    return [e for e in every if e.key not in there]


@dataclass(frozen=True)
class _Drawn:
    """Parts that are drawn, to second order about a model: evidence of eps, of what is free, and of the parts, which
    are the last `parts` of the effects."""

    model: Model
    effects: tuple[ActiveEffect, ...]
    parts: int
    evidence: Evidence
    predictions: tuple[Prediction, ...]

    @property
    def flat(self) -> int:
        """How many columns are free."""
        return len(self.coordinates) - self.parts

    @property
    def coordinates(self) -> Floats:
        """Of eps and all effects (P,)."""
        return coordinates_of(self.model, self.effects)

    @cached_property
    def beyond(self) -> Floats:
        """What parts have beyond their neutral values (P,); 0 of what is free."""
        resting = [p.resting for e in self.effects[-self.parts :] for p in e.effect.parameters]
        return np.concatenate([np.zeros(self.flat), self.coordinates[self.flat :] - resting])

    @cached_property
    def spread(self) -> float:
        """What is left of a residual where all columns are free, in units of chance."""
        return max(1.0, self.evidence.chi2(range(len(self.coordinates))) / float(self.evidence.count.sum()))

    @cached_property
    def _sums(self) -> tuple[Floats, Floats, float]:
        """Matrix (P, P), vector (P,) and constant of chi squared where no part differs, in units of what is left."""
        alike = self.evidence.about(self.beyond)
        matrix, vector, constant = (x.sum(axis=0) / self.spread for x in (alike.matrix, alike.vector, alike.constant))
        return matrix, vector, float(constant)

    @cached_property
    def _reduced(self) -> tuple[Floats, Floats, float]:
        """What is told of the parts along their principal axes (K,), the pull there, and chi squared where none
        differs, each less by what is free."""
        (a, b, none), free = self._sums, self.flat
        inverse = inverted(a[:free, :free])
        told, axes = np.linalg.eigh(a[free:, free:] - a[free:, :free] @ inverse @ a[:free, free:])
        pull = axes.T @ (b[free:] - a[free:, :free] @ inverse @ b[:free])
        return np.maximum(told, 0.0), pull, float(none - b[:free] @ inverse @ b[:free])

    @cached_property
    def _unit(self) -> float:
        """What the data tell of a part, on average over the axes."""
        return float(max(self._reduced[0].mean(), SILENT))

    def _gains(self, pull: Floats) -> Floats:
        """-2 ln likelihood (.., S) less than where none differs, of each size; pull (.., K)."""
        told, t = self._reduced[0], SIZES[:, None] / self._unit
        return (pull[..., None, :] ** 2 * (t / (1 + t * told)) - np.log1p(t * told)).sum(axis=-1)

    @cached_property
    def gained(self) -> float:
        """Of the likeliest size; 0: none."""
        return max(float(self._gains(self._reduced[1]).max()), 0.0)

    @property
    def deviance(self) -> float:
        """-2 ln likelihood at the likeliest size."""
        return (self._reduced[2] - self.gained) * self.spread

    @property
    def size(self) -> float:
        """The likeliest SD."""
        return float(np.sqrt(SIZES[int(self._gains(self._reduced[1]).argmax())] / self._unit))

    @cached_property
    def _chance(self) -> Floats:
        """What is gained where none differs (DRAWS,)."""
        told = self._reduced[0]
        pull = np.random.default_rng(0).normal(size=(DRAWS, len(told))) * np.sqrt(told)
        return np.maximum(self._gains(pull).max(axis=-1), 0.0)

    def by_chance(self, error: float) -> float:
        """The most of that, but for an error."""
        return float(np.quantile(self._chance, 1 - error))

    @cached_property
    def _posterior(self) -> tuple[Floats, Floats]:
        """How far all columns (P,) are from where no part differs, and their deviations (P,)."""
        matrix, vector, _ = self._sums
        held = np.concatenate([np.zeros(self.flat), np.full(self.parts, 1 / self.size**2)])
        covariance = inverted(matrix + np.diag(held))
        return covariance @ vector, np.sqrt(np.diag(covariance))

    @property
    def likeliest(self) -> Floats:
        """Coordinates (P,)."""
        return np.asarray(self.coordinates - self.beyond + self._posterior[0])

    @property
    def deviations(self) -> Floats:
        """Of all coordinates (P,)."""
        return self._posterior[1]


def _beside(motion: Motion, settled: Fit, parts: Sequence[ActiveEffect]) -> _Drawn:
    """About a fit, of parts that it has no effect at."""
    evidence, found = linearised(motion, settled.model, settled.effects, parts, hold=False, near=settled.predictions)
    return _Drawn(settled.model, (*settled.effects, *parts), len(parts), evidence, found)


def _without(motion: Motion, drawn: _Drawn, effect: ActiveEffect) -> _Drawn:
    """The same without an effect, the others and the parts as they are."""
    kept = [e for e in drawn.effects if e.key != effect.key]
    return _at(motion, drawn, kept, coordinates_of(drawn.model, kept))


def _settled(motion: Motion, drawn: _Drawn) -> _Drawn:
    """Newton's method in all coordinates and the size, as long as the likelihood grows."""
    for _ in range(ROUNDS):
        again = _at(motion, drawn, drawn.effects, drawn.likeliest)
        whole = again.evidence.count.sum() == drawn.evidence.count.sum()
        if not whole or again.deviance > drawn.deviance - SETTLED:
            break
        drawn = again
    return drawn


def _at(motion: Motion, drawn: _Drawn, effects: Sequence[ActiveEffect], x: Floats) -> _Drawn:
    """About other coordinates (P,) of some effects. Parts may be better than neutral, what is free keeps its bounds."""
    free, parts = effects[: -drawn.parts], effects[-drawn.parts :]
    model = with_values(drawn.model, free, x[: -drawn.parts], motion.held)
    parts = [_unbound(model.body, e, float(c)) for e, c in zip(parts, x[-drawn.parts :], strict=True)]
    every = (*at_values(model, free), *parts)
    model = replace(model, effects=(*model.effects, *parts))
    evidence, predicted = linearised(motion, model, every, hold=False, near=drawn.predictions)
    return _Drawn(model, every, drawn.parts, evidence, predicted)


def _unbound(body: Body, part: ActiveEffect, x: float) -> ActiveEffect:
    """A part with another coordinate, within its bounds but for one that is the neutral value."""
    (p,) = part.effect.parameters
    ((low, high),) = part.effect.coordinate_bounds(body, part.place)
    low, high = (-np.inf if low == p.resting else low), (np.inf if high == p.resting else high)
    x = float(np.clip(x, low, high))
    return ActiveEffect.model_construct(name=part.name, place=part.place, parameters={p.name: p.value(x or TINY)})


def _doubt(drawn: _Drawn, settled: Fit) -> dict[Coordinate, Doubted]:
    """Coordinates of what is settled on, beside parts that differ."""
    names = [(e.name, e.place, i) for e in settled.effects for i in range(len(e.effect.parameters))]
    pairs = zip(names, drawn.likeliest[1:], drawn.deviations[1:], strict=False)
    return {name: Doubted(float(value), float(deviation)) for name, value, deviation in pairs}
