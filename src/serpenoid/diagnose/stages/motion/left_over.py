"""What is left beside names, in words: its pattern, trials that it divides, and effects that were refused."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from serpenoid.diagnose.data.noise.paths import path_error
from serpenoid.diagnose.data.windows.windows import Prediction
from serpenoid.diagnose.inference.doubt.differing import Differing
from serpenoid.diagnose.inference.fits.finding import Divided
from serpenoid.diagnose.inference.search.names import Refused
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.diagnose.residuals.begun_with_a_gait import begun_with_a_gait
from serpenoid.diagnose.residuals.from_trial_to_trial import after_some, as_floors_do, more_than_before, one_in_each
from serpenoid.diagnose.residuals.in_some_trials import one_cause_in_some
from serpenoid.diagnose.residuals.residual_words import pattern
from serpenoid.wording import NOT_NAMED

TOLD = 0.01  # of what is left: refused effects that would take less are not spoken of


def strayed(found: Selection, parts: Differing | None, mend: bool) -> float:
    """Path error [m] of all that is there, as the verdict takes it; mend: of steps across gaps, too."""
    return path_error(found.motion, predicted_by(found, parts), mend)


def predicted_by(found: Selection, parts: Differing | None) -> Sequence[Prediction]:
    """By what is named, what is below detection, and parts that differ."""
    return found.settled.predictions if parts is None else parts.predictions


def refusals(refused: Sequence[Refused]) -> tuple[str, ...]:
    """Why effects that the search tried are not named, what takes away most first."""
    most = {r.effect.key: r for r in sorted(refused, key=lambda r: r.share) if r.share >= TOLD}
    ordered = sorted(most.values(), key=lambda r: -r.share)
    chance, beyond = [r for r in ordered if not r.beyond], [r for r in ordered if r.beyond]
    said = [f"{NOT_NAMED}a wrong effect could take away as much: {_shares(chance)}"] if chance else []
    return (*said, *(f"{NOT_NAMED}it is pushed beyond its bound: {_shares([r])}" for r in beyond))


def _shares(refused: Sequence[Refused]) -> str:
    first, *others = refused
    more = "".join(f", {r.effect.called} ({r.share:.0%})" for r in others)
    return f"{first.effect.called} ({first.share:.0%} of what is left){more}"


def left_over(found: Selection, parts: Differing | None, mend: bool) -> tuple[tuple[str, ...], Divided | None]:
    """What neither the effects named nor one too weak to be named, nor parts that differ, account for; and how trials
    are divided by it, if they are, or a hint at that. mend: steps across gaps are known."""
    motion, predictions = found.motion, predicted_by(found, parts)
    eps = found.settled.model.medium.anisotropy_ratio
    words = pattern(motion, predictions, path_error(motion, predictions, mend))
    divided = differ = more_than_before(motion, predictions, found.null.model)
    cause = one_cause_in_some(motion, found.settled, () if differ is None else differ.changed)
    hint = cause if cause is not None and cause.hint else None
    if cause is not None and hint is None:
        divided = cause if differ is None else replace(cause, words=f"{cause.words}; {differ.words}")
    floors = () if divided is not None else as_floors_do(motion, predictions, eps)
    if divided is None and words and not floors:
        divided = after_some(motion, found.null.model)
        if divided is None and not found.best.effects:
            divided = begun_with_a_gait(motion, found.null)
    if divided is not None:
        return (*words, divided.words), divided
    return (*words, *(floors or (one_in_each(motion, predictions, eps) if words else ()))), hint
