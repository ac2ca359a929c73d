"""What not knowing a film's scale does to a fit, to first order: each film a standard error larger, by itself.

    shift_i = -C J' (e_i - e),     SD^2 = sum_i shift_i^2        C: covariance, J: derivatives, i: films

with e the white defects (`likelihood`). Errors of films are independent of each other, and of how their points tell
bends and places (`measure/animals/film_scale.py`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.body import Floats
from serpenoid.compare.likelihood import Segment, Solution, whiten
from serpenoid.compare.segments import trial_segments
from serpenoid.measure.load import Campaign, with_other_scales
from serpenoid.model import Model

Films = tuple[tuple[Segment, ...], ...]  # of each whose scale is not known, a standard error larger


def larger_films(campaign: Campaign, name: str | None) -> Films:
    """Of a trial by name, or of all that can be fitted."""
    named = {trial.name: trial for trial in campaign.trials}
    larger = [made for made in with_other_scales(campaign) if name in (None, made.name)]
    return tuple(trial_segments(made, named[made.name]) for made in larger if made.motion and made.passages)


def scales_sd(model: Model, segments: Sequence[Segment], films: Films, solution: Solution) -> Floats:
    """Standard error (P,) of the fitted numbers from not knowing scales."""
    square = np.zeros(len(solution.values))
    for film in films:
        own = [w for w, s in zip(solution.segments, segments, strict=True) if s.trial == film[0].trial]
        other = whiten(model, film, solution.names, solution.values)
        pull = [w.by_parameters.reshape(-1, len(square)).T @ (o.defect - w.defect).ravel()
                for w, o in zip(own, other, strict=True)]  # fmt: skip
        square += (solution.covariance @ np.sum(pull, axis=0)) ** 2
    return np.asarray(np.sqrt(square))
