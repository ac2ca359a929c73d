"""All laws of the body at once, for predictions, where what is named leaves much.

A robot on wheels follows several laws together: axles behind the joints, tyres that slip, bearings that resist. None of
them may do much without the others, and then a search that adds one after another finds none. So all are fitted at
once, from where they change nothing, and those that earn nothing are dropped. So many numbers mend any law's error, and
are no names; whether they predict better, gaits that they were not fitted to say.
"""

from __future__ import annotations

from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.inference.discrepancy import information_criterion
from serpenoid.diagnose.inference.medium import TO_THE_END, Fit, candidates_of, coordinates_of, fit
from serpenoid.diagnose.inference.select import Selection, told, unclear
from serpenoid.effects.active import ActiveEffect
from serpenoid.parallel import in_processes


def laws_together(found: Selection) -> Fit | None:
    """The likelier of two fits, errors of the law included: beside what was found, and in its place; None where little
    is left, or one gait is all there is, or neither is likelier than what was found."""
    motion, best = found.motion, found.settled
    if not unclear(found.best) or len(set(motion.labels)) < 2:
        return None
    whole = [c for c in (*best.effects, *laws_of_the_body(motion, best)) if of_the_body(c) and not c.effect.remembers]
    placed = [e for e in best.effects if e not in whole]
    tries = len(candidates_of(found.null))
    fits = [best, *in_processes([(_together, (motion, best, e, tries)) for e in ([*placed, *whole], whole)])]
    entire = [f for f in fits if f.evidence.count.sum() >= best.evidence.count.sum()]
    likeliest = min(entire, key=lambda f: information_criterion(motion, f))
    return None if likeliest is best else likeliest


def laws_of_the_body(motion: Motion, base: Fit) -> list[ActiveEffect]:
    """All that are candidates beside a fit."""
    return [c for c in candidates_of(base) if of_the_body(c) and c.name not in motion.untestable]


def of_the_body(effect: ActiveEffect) -> bool:
    """Whether it is a law by which the whole body moves, wherever it is."""
    return effect.place is None and effect.effect.site == "medium" and not effect.effect.of_the_room


def _together(motion: Motion, best: Fit, effects: list[ActiveEffect], tries: int) -> Fit:
    """Effects fitted at once, without those that earn nothing."""
    x = coordinates_of(best.model, effects)
    return told(motion, fit(motion, best.model, effects, x, TO_THE_END, best.predictions), tries)
