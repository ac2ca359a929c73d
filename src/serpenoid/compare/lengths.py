"""What not knowing the edge lengths does to a fit: a jackknife over blocks of frames, to first order.

Lengths that are not given are medians of the distances between markers, of an animal means of arcs. Estimated without a
block of frames they are a little others, and so are shapes, poses and, to first order, the fitted numbers:

    shift_b = -C J' (e_b - e),     SD^2 = (B - 1) / B sum_b (shift_b - mean)^2        C: covariance, J: derivatives

with e the white defects (`likelihood`). Measured (40 recordings of one gait by cameras alone, 0.2 mm): eps scatters by
1.9e-5 with estimated lengths, by 1.4e-5 with given ones.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.compare.likelihood import Segment, Solution, whiten
from serpenoid.compare.scales import Films, larger_films
from serpenoid.compare.segments import trial_segments
from serpenoid.measure.load import Campaign, with_other_lengths
from serpenoid.model import Model

BLOCKS = 8


@dataclass(frozen=True)
class Others:
    """The same segments with the lengths of each block left out; none where lengths are given. And films, larger."""

    models: tuple[Model, ...] = ()
    segments: tuple[tuple[Segment, ...], ...] = ()
    films: Films = ()


def others_of(campaign: Campaign, model: Model) -> Callable[[str | None], Others]:
    """What is known of other lengths and scales, for a trial by name, or for all that can be fitted (None)."""
    others = with_other_lengths(campaign, BLOCKS)
    models = tuple(Model(other.body, model.medium) for other in others)

    def of(name: str | None) -> Others:
        chosen = [
            [pair for pair in zip(other.trials, campaign.trials, strict=True) if _wanted(pair[1].name, name)]
            for other in others
        ]
        segments = [
            tuple(s for made, trial in pairs if trial.motion and trial.passages for s in trial_segments(made, trial))
            for pairs in chosen
        ]
        return Others(models, tuple(segments), larger_films(campaign, name))

    return of


def _wanted(name: str, asked: str | None) -> bool:
    return asked is None or name == asked


def lengths_sd(others: Others, solution: Solution) -> Floats:
    """Standard error (P,) of the fitted numbers from not knowing the lengths."""
    if not others.models:
        return np.zeros(len(solution.values))
    shifts = np.stack([lengths_shift(m, s, solution) for m, s in zip(others.models, others.segments, strict=True)])
    blocks = len(shifts)
    return np.asarray(np.sqrt((blocks - 1) / blocks * ((shifts - shifts.mean(axis=0)) ** 2).sum(axis=0)))


def lengths_shift(model: Model, segments: tuple[Segment, ...], solution: Solution) -> Floats:
    """Of the fitted numbers (P,), to first order, with the lengths of one block."""
    other = whiten(model, segments, solution.names, solution.values)
    pull = [w.by_parameters.reshape(-1, len(solution.values)).T @ (o.defect - w.defect).ravel()
            for w, o in zip(solution.segments, other, strict=True)]  # fmt: skip
    return -np.asarray(solution.covariance @ np.sum(pull, axis=0))
