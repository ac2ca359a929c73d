"""All laws of the body at once, for predictions, where what is named leaves much.

A robot on wheels follows several laws together: axles behind the joints, tyres that slip, bearings that resist. None of
them may do much without the others, and then a search that adds one after another finds none. So all are fitted at
once, from where they change nothing, and dropped one after another, each time the one without which the others, fitted
again, are likeliest, errors of the law included. Several of them bound the same forces in their own ways (dry friction,
a power of speed, tyres that slip): by what one takes away beside the others the wrong one would be dropped. So many
numbers mend any law's error, and are no names; whether they predict better, gaits that they were not fitted to say.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

import numpy as np

from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.inference.discrepancy import information_criterion
from serpenoid.diagnose.inference.medium import TO_THE_END, Fit, candidates_of, coordinates_of, fit, fit_guided
from serpenoid.diagnose.inference.names import each_without
from serpenoid.diagnose.inference.select import Selection, unclear
from serpenoid.effects.active import ActiveEffect


def laws_together(found: Selection) -> Fit | None:
    """The likeliest fit, errors of the law included, of laws beside what was found and in its place; None where little
    is left, or one gait is all there is, or none is likelier than what was found."""
    motion, null, best = found.motion, found.null, found.settled
    if not unclear(found.best) or len(set(motion.labels)) < 2:
        return None
    anew = _of_one_step(laws_of_the_body(motion, null))
    beside = _of_one_step([*best.effects, *laws_of_the_body(motion, best)])
    begun = [_at_once(motion, null, anew), *([_at_once(motion, best, beside)] if best.effects else [])]
    likeliest = _likeliest_of([best, *chain.from_iterable(_fewer_and_fewer(motion, f) for f in begun)], motion)
    slow = [c for c in laws_of_the_body(motion, likeliest) if c.effect.remembers]
    more = [_at_once(motion, likeliest, [*likeliest.effects, c]) for c in slow]
    likeliest = _likeliest_of([likeliest, *more], motion)
    return None if likeliest is best else likeliest


def _of_one_step(effects: Sequence[ActiveEffect]) -> list[ActiveEffect]:
    """Those that do not remember the steps before: of one that does every fit takes many times as long."""
    return [c for c in effects if not c.effect.remembers]


def _likeliest_of(fits: Sequence[Fit], motion: Motion) -> Fit:
    """Of those that predict all windows that the first does."""
    entire = [f for f in fits if f.evidence.count.sum() >= fits[0].evidence.count.sum()]
    return min(entire, key=lambda f: information_criterion(motion, f))


def laws_of_the_body(motion: Motion, base: Fit) -> list[ActiveEffect]:
    """All that are candidates beside a fit."""
    return [c for c in candidates_of(base) if of_the_body(c) and c.name not in motion.untestable]


def of_the_body(effect: ActiveEffect) -> bool:
    """Whether it is a law by which the whole body moves, wherever it is."""
    return effect.place is None and effect.effect.site == "medium" and not effect.effect.of_the_room


def _at_once(motion: Motion, best: Fit, effects: Sequence[ActiveEffect]) -> Fit:
    """Effects fitted from where those that were not found change nothing."""
    return fit(motion, best.model, effects, coordinates_of(best.model, effects), TO_THE_END, best.predictions)


def _fewer_and_fewer(motion: Motion, found: Fit) -> list[Fit]:
    """A fit, and one after another with fewer of its effects."""
    passed = [found]
    while found.effects:
        found = _with_fewer(motion, found)
        passed.append(found)
    return passed


def _with_fewer(motion: Motion, found: Fit) -> Fit:
    """Without the effect whose place the others take best; or without all whose place they take, if they take all."""
    bases = each_without(motion, found)
    own, each = information_criterion(motion, found), [information_criterion(motion, b) for b in bases]
    least = int(np.argmin(each))
    idle = [e for e, without in zip(found.effects, each, strict=True) if without < own]
    if len(idle) > 1:
        bare = _at_once(motion, found, [e for e in found.effects if e not in idle])
        if information_criterion(motion, bare) < each[least]:
            return bare
    return fit_guided(motion, bases[least], TO_THE_END)
