"""Effects of the observation model as they are tried: fitted beside one another to the joint angles and edges that
markers show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from serpenoid.body import Body, Floats
from serpenoid.diagnose.data import chance
from serpenoid.diagnose.data.cameras.columns import all_keys, columns_of
from serpenoid.diagnose.data.cameras.observation import Observation, values_of
from serpenoid.diagnose.inference.fits.evidence import Evidence
from serpenoid.diagnose.inference.fits.prices import PLAINLY, Priced
from serpenoid.diagnose.inference.search.null import Scored, largest_by_chance
from serpenoid.diagnose.stages.observation.marker_evidence import Sample, channels_left, evidence, misfit, signature
from serpenoid.effects.active import ActiveEffect
from serpenoid.parallel import in_processes

CONVERGED = 1e-4  # chi squared: the step that gains it is a hundredth of a standard deviation, the next far smaller
Key = tuple[str, int | None]


@dataclass(frozen=True)
class Looked:
    """Some effects of the observation model, fitted beside one another.

    before: the model without them. without: names that are no candidates.
    """

    data: Sample
    now: Observation
    before: Observation
    keys: tuple[Key, ...] = ()
    without: frozenset[str] = frozenset()

    @property
    def size(self) -> int:
        """See `Explanation`."""
        return len(self.keys)

    @property
    def own(self) -> list[int]:
        """Columns of the effects."""
        return [c for k in self.keys for c in columns_of(self.data.body, *k)]

    @property
    def others(self) -> list[Key]:
        """What else might be there."""
        return [k for k in all_keys(self.data.body) if k not in self.keys and k[0] not in self.without]

    @cached_property
    def sums(self) -> Evidence:
        """All columns, about this model; without its only effect that is the model with which the search began."""
        known, numbers = self.data.sums, self.now.numbers.tobytes()
        if numbers not in known:
            known[numbers] = evidence(self.data, self.now)
        return known[numbers]

    @cached_property
    def channels_left(self) -> Floats:
        """What this model leaves of all channels (F, 2 m + 1), over the noise level."""
        return channels_left(self.data, self.now)

    @cached_property
    def structure(self) -> Floats:
        """Its mean square (2 m + 1,), in units of noise; 0 where chance alone makes as much."""
        return chance.structure(self.channels_left, self.data.following)

    @cached_property
    def priced(self) -> Priced:
        """See `Explanation`."""
        return Priced(misfit(self.data, self.now), len(self.own), self.data.count)

    @cached_property
    def needed(self) -> float:
        """Chi squared that an effect must take away: the best of all candidates takes as much by chance."""
        body, order = self.data.body, [*self.own, *(c for k in self.others for c in columns_of(self.data.body, *k))]
        summed = self.sums.of_columns(order)
        ends = np.cumsum([len(self.own), *(len(columns_of(body, *k)) for k in self.others)])
        groups = tuple(tuple(range(a, b)) for a, b in zip(ends[:-1], ends[1:], strict=True))
        return largest_by_chance([Scored(summed, len(self.own), groups)])

    def beside(self, key: Key) -> Looked:
        """One more effect, all fitted."""
        return self.beside_each([key])[0]

    def beside_each(self, several: Sequence[Key]) -> list[Looked]:
        """The same of each of several."""
        every = [(*self.keys, key) for key in several]
        found = in_processes([(solved, (self.data, self.now, keys, self.sums)) for keys in every])
        return [replace(self, now=now, keys=keys) for now, keys in zip(found, every, strict=True)]

    def without_one(self, index: int) -> Looked:
        """One less, the others fitted again."""
        kept = tuple(k for i, k in enumerate(self.keys) if i != index)
        now = self._cleared(self.keys[index])
        return replace(self, now=solved(self.data, now, kept), keys=kept)

    def each_without(self, some: Sequence[int]) -> list[Looked | None]:
        """One less, each of some in turn; None of one that to first order takes away far more than is needed."""
        return [None if self._worth(i) > PLAINLY * self.needed else self.without_one(i) for i in some]

    def _worth(self, index: int) -> float:
        """Chi squared that an effect takes away, to first order."""
        key = self.keys[index]
        at, away = [self.own.index(c) for c in columns_of(self.data.body, *key)], self.changed_by(key)
        covariance = self.sums.solve(self.own)[1][np.ix_(at, at)]
        return float(away @ np.linalg.solve(covariance, away))

    def changed_by(self, key: Key) -> Floats:
        """How far an effect's numbers are from what they were before."""
        now, former = (np.array(values_of(self.data.body, model, *key)) for model in (self.now, self.before))
        return np.asarray(now - former)

    def _cleared(self, key: Key) -> Observation:
        """The model with one effect's numbers as they were before."""
        now = self.now
        for column, change in zip(columns_of(self.data.body, *key), self.changed_by(key), strict=True):
            now = now.with_column(column, -float(change))
        return now

    def strength(self, key: Key) -> float:
        """The worst channel's RMS of what one effect alone has changed, over the noise level."""
        return float(self.signature(key).max())

    def signature(self, key: Key) -> Floats:
        """Of all channels."""
        now, before = (only(self.data.body, model, key) for model in (self.now, self.before))
        return signature(self.data, now, before)

    def known(self, key: Key) -> dict[str, float]:
        """An effect's values before, by parameter; empty where it was not there."""
        effect = effect_of(replace(self, now=self.before), key)
        return {} if effect.is_neutral else dict(effect.parameters)


def effect_of(found: Looked, key: Key) -> ActiveEffect:
    """One of the effects with its values."""
    return ActiveEffect.neutral(*key).with_coordinates(values_of(found.data.body, found.now, *key))


def gained_beyond(found: Looked, key: Key) -> float:
    """Chi squared that an effect gains by numbers beyond its bounds, the others as they are; 0 of what is within."""
    effect, values = effect_of(found, key), values_of(found.data.body, found.now, *key)
    held, now = [*effect.parameters.values()], found.now
    if effect.effect.marks is None:
        held = effect.coordinates[:-1]  # the last says that it is there
    if np.allclose(held, values, rtol=1e-9, atol=0.0):
        return 0.0
    for column, value, end in zip(columns_of(found.data.body, *key), values, held, strict=True):
        now = now.with_column(column, end - value)
    return misfit(found.data, now) - found.priced.chi2


def solved(
    data: Sample, now: Observation, keys: Sequence[Key], begun: Evidence | None = None, rounds: int = 4
) -> Observation:
    """Gauss-Newton in the numbers of the given effects, until a step gains next to nothing; begun: evidence of all
    columns about the model with which it begins."""
    columns = [c for k in keys for c in columns_of(data.body, *k)]
    for i in range(rounds if columns else 0):
        sums = begun.of_columns(columns) if begun is not None and not i else evidence(data, now, columns)
        step, _ = sums.solve(range(len(columns)))
        for column, amount in zip(columns, step, strict=True):
            now = now.with_column(column, float(amount))
        if sums.vector.sum(axis=0) @ step < CONVERGED:
            break
    return now


def only(body: Body, model: Observation, key: Key) -> Observation:
    """An observation model with one effect of a model alone."""
    alone = Observation.neutral(body)
    for column, value in zip(columns_of(body, *key), values_of(body, model, *key), strict=True):
        alone = alone.with_column(column, value)
    return alone
