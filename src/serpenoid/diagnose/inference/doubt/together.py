"""All laws of the body at once, for predictions, where what is named leaves much.

A robot on wheels follows several laws together: axles behind the joints, tyres that slip, bearings that resist. None of
them may do much without the others, and then a search that adds one after another finds none. So all are fitted at
once, from where they change nothing, and dropped one after another, each time the one without which the others, fitted
again, are likeliest, errors of the law included. Several of them bound the same forces in their own ways (dry friction,
a power of speed, tyres that slip): by what one takes away beside the others the wrong one would be dropped. So many
numbers mend any law's error, and are no names; whether they predict better, gaits that they were not fitted to say.
The laws by which a robot moved already are its reference's: beside one none is looked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import NamedTuple

from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.inference.fits.medium import TO_THE_END, Fit, candidates_of, coordinates_of, fit, fit_guided
from serpenoid.diagnose.inference.search.discrepancy import information_criterion
from serpenoid.diagnose.inference.search.names import each_without
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.diagnose.inference.search.tries import unclear
from serpenoid.effects.active import ActiveEffect
from serpenoid.parallel import in_processes


class _Judged(NamedTuple):
    """A fit and its information criterion, errors of the law included: the likeliest has the least."""

    fit: Fit
    criterion: float


def laws_together(found: Selection) -> Fit | None:
    """The likeliest fit, errors of the law included, of laws beside what was found and in its place; None where little
    is left, or one gait is all there is, or there is a reference, or none is likelier than what was found."""
    motion, null, best = found.motion, found.null, found.settled
    if not unclear(found.best) or len(set(motion.labels)) < 2 or motion.ratio is not None:
        return None
    begun = [(null, _of_one_step(laws_of_the_body(motion, null)))]
    if best.effects:
        begun.append((best, _of_one_step([*best.effects, *laws_of_the_body(motion, best)])))
    ended = in_processes([(_fewer_and_fewer, (motion, base, effects)) for base, effects in begun])
    likeliest = _likeliest_of([_judged(motion, best), *chain.from_iterable(ended)])
    slow = [c for c in laws_of_the_body(motion, likeliest.fit) if c.effect.remembers]
    more = in_processes([(_judged_at_once, (motion, likeliest.fit, [*likeliest.fit.effects, c])) for c in slow])
    likeliest = _likeliest_of([likeliest, *more])
    return None if likeliest.fit is best else likeliest.fit


def _of_one_step(effects: Sequence[ActiveEffect]) -> list[ActiveEffect]:
    """Those that do not remember the steps before: of one that does every fit takes many times as long."""
    return [c for c in effects if not c.effect.remembers]


def _judged(motion: Motion, fitted: Fit) -> _Judged:
    return _Judged(fitted, information_criterion(motion, fitted))


def _likeliest_of(several: Sequence[_Judged]) -> _Judged:
    """Of those that predict all windows that the first does."""
    least = several[0].fit.evidence.count.sum()
    return min((j for j in several if j.fit.evidence.count.sum() >= least), key=lambda j: j.criterion)


def laws_of_the_body(motion: Motion, base: Fit) -> list[ActiveEffect]:
    """All that are candidates beside a fit."""
    return [c for c in candidates_of(base) if of_the_body(c) and c.name not in motion.untestable]


def of_the_body(effect: ActiveEffect) -> bool:
    """Whether it is a law by which the whole body moves, wherever it is."""
    return effect.place is None and effect.effect.site == "medium" and not effect.effect.of_the_room


def _at_once(motion: Motion, best: Fit, effects: Sequence[ActiveEffect]) -> Fit:
    """Effects fitted from where those that were not found change nothing."""
    return fit(motion, best.model, effects, coordinates_of(best.model, effects), TO_THE_END, best.predictions)


def _judged_at_once(motion: Motion, best: Fit, effects: Sequence[ActiveEffect]) -> _Judged:
    return _judged(motion, _at_once(motion, best, effects))


def _fewer_and_fewer(motion: Motion, base: Fit, effects: Sequence[ActiveEffect]) -> list[_Judged]:
    """Effects fitted at once, and one after another with fewer of them."""
    passed = [_judged_at_once(motion, base, effects)]
    while passed[-1].fit.effects:
        passed.append(_with_fewer(motion, passed[-1]))
    return passed


def _with_fewer(motion: Motion, found: _Judged) -> _Judged:
    """Without the effect whose place the others take best; or without all whose place they take, if they take all."""
    each = [_judged(motion, base) for base in each_without(motion, found.fit)]
    least = min(each, key=lambda j: j.criterion)
    idle = {e.key for e, without in zip(found.fit.effects, each, strict=True) if without.criterion < found.criterion}
    if len(idle) > 1:
        bare = _judged_at_once(motion, found.fit, [e for e in found.fit.effects if e.key not in idle])
        if bare.criterion < least.criterion:
            return bare
    return _judged(motion, fit_guided(motion, least.fit, TO_THE_END))
