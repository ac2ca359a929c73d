"""Effects of servos that a reference had and that are gone since.

A value that changes nothing is one like any other where fits come by it. Two kinds of effects keep them from that: one
that acts or does not (a joint that was stuck), and one that does nothing from some value on (a speed limit above every
speed), where a fit stops.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf

from serpenoid.diagnose.inference.fits.finding import Named, excludable, interval
from serpenoid.diagnose.inference.fits.prices import most_gained
from serpenoid.diagnose.stages.actuation.actuation_search import Played, numbers_of
from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.effects.active import ActiveEffect


def without_gone(data: Plays) -> tuple[Plays, tuple[Named, ...]]:
    """Without known effects that have no value which changes nothing, and without which readings are likelier than by
    chance; and these as names."""
    gone: tuple[Named, ...] = ()
    for e in data.known:
        if any(p.neutral is not None for p in e.effect.parameters):
            continue
        rest = replace(data, known=tuple(other for other in data.known if other.key != e.key))
        now, without = Played(data).priced, Played(rest).priced
        if excludable(now.chi2, without.chi2, without.count, most_gained(numbers_of(e), len(data.known))):
            gone += (Named(e, {}, rest.strength(e), before=e.parameters, gone=True),)
            data = rest
    return data, gone


def as_neutral(best: Played, named: Named) -> Named:
    """A known effect with the value that changes nothing, and intervals over it, where readings do not exclude that."""
    e = named.effect
    if not named.before or any(p.neutral is None for p in e.effect.parameters):
        return named
    resting = ActiveEffect.neutral(e.name, e.place)
    other = Played(best.data, tuple(resting if o.key == e.key else o for o in best.effects))
    if excludable(other.priced.chi2, best.priced.chi2, best.priced.count, most_gained(numbers_of(e), 1)):
        return named
    ends = {}
    for name, x in resting.parameters.items():
        low, high = named.intervals[name]
        ends[name] = interval([min(x, -inf if low is None else low), max(x, inf if high is None else high)])
    return replace(named, effect=resting, intervals=ends)
