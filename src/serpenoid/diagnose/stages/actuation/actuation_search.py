"""Steps of the search for actuation effects: one more, all laws of all servos anew, a law of each joint's own."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from serpenoid.diagnose.inference.fits.finding import VISIBLE
from serpenoid.diagnose.inference.fits.prices import Priced, cheapest, gained_by_chance
from serpenoid.diagnose.stages.actuation.actuation_by_joint import Attempt
from serpenoid.diagnose.stages.actuation.actuation_candidates import places_of, shown
from serpenoid.diagnose.stages.actuation.actuation_evidence import needed, slopes_of_each
from serpenoid.diagnose.stages.actuation.actuation_refit import refined, with_laws
from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.effects.active import ActiveEffect
from serpenoid.parallel import in_processes

ALONE = 3  # candidates that may do nothing by themselves, of a search's step


@dataclass(frozen=True)
class Played:
    """Some effects of the servos, fitted beside one another."""

    data: Plays
    effects: tuple[ActiveEffect, ...] = ()

    @cached_property
    def angles(self) -> np.ndarray:
        """What servos would read (R, m)."""
        return self.data.realised(self.effects)

    @cached_property
    def priced(self) -> Priced:
        """See `Explanation`."""
        numbers = sum(numbers_of(e) for e in self.effects)
        return Priced(float(self.data.chi2(self.angles).sum()), numbers, float(self.data.often.sum()))

    @property
    def size(self) -> int:
        """See `Explanation`."""
        return len(self.effects)

    @cached_property
    def needed(self) -> float:
        """Chi squared that each effect must take away."""
        return needed(self.data, self.effects)

    def worth(self, some: Sequence[int]) -> list[float]:
        """Chi squared that each of some effects takes away, by index, the others fitted again to first order."""
        every = [slopes for _, slopes in slopes_of_each(self.data, self.effects, self.effects, self.angles)]
        without = self.data.realised_each([self.effects[:i] + self.effects[i + 1 :] for i in some])
        return [self._left_to_first_order(i, every, p) - self.priced.chi2 for i, p in zip(some, without, strict=True)]

    def _left_to_first_order(self, index: int, every: Sequence[np.ndarray], played: np.ndarray) -> float:
        """Chi squared of what is played (R, m) without an effect, the others moved along their slopes (P, R, m)."""
        left = self.data.left(played) / self.data.noise
        slopes = [slope for i, own in enumerate(every) if i != index for slope in own]
        if not slopes:
            return float((left**2).sum())
        columns = np.reshape(slopes, (len(slopes), -1))
        pull = columns @ left.ravel()
        return float((left**2).sum() - pull @ np.linalg.lstsq(columns @ columns.T, pull)[0])

    @property
    def followed(self) -> bool:
        """Whether what is left of no joint's readings is visible beside their noise."""
        return bool(self.data.missed(self.angles).max() < VISIBLE**2)


def next_one(best: Played, tries: Sequence[Attempt]) -> tuple[ActiveEffect, Played] | None:
    """The cheapest candidate, and all with it, fitted again, if it is still worth it: where nothing says when trials
    began, a candidate was tried beside the beginnings that all joints' fits together make, and may do nothing alone."""
    rest, size, count = list(tries), best.priced.parameters, best.priced.count
    for _ in range(min(ALONE, len(tries))):
        priced = [Priced(float(t.chi2.sum()), size + numbers_of(t.effect), count) for t in rest]
        found = cheapest(best.priced, priced, len(tries))
        if found is None:
            break
        new, grown = one_more(best, [t.effect for t in rest], [p.chi2 for p in priced], found)
        if cheapest(best.priced, [grown.priced], len(tries)) is not None:
            return new, grown
        del rest[found]
    return None


def one_more(
    best: Played, tries: Sequence[ActiveEffect], chi2: Sequence[float], found: int
) -> tuple[ActiveEffect, Played]:
    """The candidate that was found, and all with it, fitted again; or the best of those of fewer numbers, if that is
    then cheaper: candidates are fitted roughly, and one that came less far is no reason for one more number."""
    by_chi2 = sorted(range(len(tries)), key=lambda i: chi2[i], reverse=True)
    kinds = {numbers_of(tries[i]): i for i in by_chi2} | {numbers_of(tries[found]): found}
    chosen = [tries[i] for size, i in sorted(kinds.items()) if size <= numbers_of(tries[found])]
    grown = [Played(best.data, refined(best.data, [*best.effects, new], new)) for new in chosen]
    cheaper = cheapest(best.priced, [g.priced for g in grown], len(tries)) if len(grown) > 1 else None
    index = len(grown) - 1 if cheaper is None else cheaper
    return chosen[index], grown[index]


def of_all_anew(best: Played, barred: Collection[str] = ()) -> Played:
    """With the laws of all servos that do it for least, as long as others do it for less: one law may stand for several
    of as many numbers together and leave too little to be seen. One number more is asked for where more than chance is
    left. A name more is to gain as much as the best of all candidates does by chance, as in every step of the search:
    two laws of one number each are less likely together than one law of two. barred: names that are not tried."""
    name = gained_by_chance(sum(len(places_of(kind, best.data)) for kind in shown(best.data)))
    while True:
        sets = [s for s in _others_of_all(best) if not {*s} & {*barred}]
        grown = [Played(best.data, e) for e in in_processes([(with_laws, (best.data, best.effects, s)) for s in sets])]
        more = [name * (g.size - best.size) for g in grown]
        found = cheapest(best.priced, [g.priced for g in grown], len(grown), more)
        if found is None:
            return best
        best = grown[found]


def each_its_own(best: Played) -> Played:
    """With a law of one joint at the only one that lacks it, in the place of one of all with the same numbers, where
    that does it for less: all begin elsewhere then, which no smaller step does."""
    for common in [e for e in best.effects if e.place is None]:
        numbers = [p.name for p in common.effect.parameters]
        for name in {e.name for e in best.effects if e.place is not None}:
            own = [e for e in best.effects if e.name == name]
            free = {j + 1 for j in range(best.data.readings.shape[1])} - {e.place for e in own}
            if len(free) != 1 or [p.name for p in own[0].effect.parameters] != numbers:
                continue
            every = [*own, ActiveEffect.neutral(name, free.pop()).with_coordinates(np.zeros(len(numbers)))]
            moved = [e.with_coordinates(np.add(e.coordinates, common.coordinates)) for e in every]
            kept = [e for e in best.effects if e.name != name and e is not common]
            other = Played(best.data, refined(best.data, [*kept, *moved]))
            best = other if cheapest(best.priced, [other.priced], 1) is not None else best
    return best


def _others_of_all(best: Played) -> list[tuple[str, ...]]:
    """Sets of laws without a place, by name, of no more numbers than those that were found, which lack one of them at
    most; a set with no other law in it is left to `earned`."""
    own = {e.name for e in best.effects if e.place is None}
    numbers = {k.name: len(k.parameters) for k in shown(best.data) if k.place is None}
    size = sum(numbers.get(name, 0) for name in own)
    most = size + bool(best.data.structure(best.angles).max() > 0)
    sets = (s for count in range(1, most + 1) for s in combinations(numbers, count)) if size else ()
    return [s for s in sets if not own >= set(s) and len(own - set(s)) <= 1 and sum(numbers[n] for n in s) <= most]


def numbers_of(effect: ActiveEffect) -> int:
    return len(effect.effect.parameters)
