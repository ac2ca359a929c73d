"""A cause that acts in some trials alone, fitted in full: eps in all trials, and the cause in those in which it acts.

Legend: T trials, P coordinates of the cause (of another anisotropy ratio: one).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.windows.windows import Prediction, columns_of, predictions
from serpenoid.diagnose.inference.fits.bounds import LEAST_EPS, MOST_EPS
from serpenoid.diagnose.inference.fits.medium import Fit, of_windows, with_values
from serpenoid.effects.active import ActiveEffect, of_key
from serpenoid.model import Model
from serpenoid.simulation.sensitivity import EPS, Column

ROUNDS, CONVERGED = 8, 0.02  # steps of Gauss-Newton; chi squared that ends them


@dataclass(frozen=True)
class Acting:
    """change (P,): of the cause's coordinates where it acts; predicted: each trial; by: derivatives (W, 3, P) of each
    trial by the cause, in those in which it rests as well; left: chi squared."""

    change: Floats
    predicted: tuple[Prediction, ...]
    by: tuple[Floats, ...]
    left: float


def acting(motion: Motion, found: Fit, cause: ActiveEffect | None, acts: np.ndarray) -> Acting:
    """Fitted beside what a fit has found, from there and from nothing of the cause; cause: None: another anisotropy
    ratio. acts (T,): in which trials."""
    x = np.array([found.model.medium.anisotropy_ratio, *_rest(cause, 0.0)])
    best, step = _at(motion, found, cause, acts, x)
    for _ in range(ROUNDS):
        x = x + step
        new, step = _at(motion, found, cause, acts, x)
        if not new.left < best.left:
            break
        gained, best = best.left - new.left, new
        if gained < CONVERGED:
            break
    return best


def _rest(cause: ActiveEffect | None, eps: float) -> list[float]:
    """Coordinates of the cause where it does not act."""
    return [eps] if cause is None else list(cause.coordinates[:-1])


def _at(motion: Motion, found: Fit, cause: ActiveEffect | None, acts: np.ndarray, x: Floats) -> tuple[Acting, Floats]:
    """With eps and the cause's coordinates x (1 + P), of another ratio what is added to eps; and the next step."""
    columns: tuple[Column, ...] = (EPS,) if cause is None else columns_of([cause])
    model = found.model
    still = with_values(model, [], x[:1], model.effects)
    absent = [] if cause is None or of_key(model.effects, cause.key) else [cause]
    predicted = list(found.predictions)
    for own, candidates, some in (
        (still, absent, np.flatnonzero(~acts)),
        (_with(model, cause, x), [], np.flatnonzero(acts)),
    ):
        tracks, near = [motion.tracks[i] for i in some], [found.predictions[i] for i in some]
        for i, p in zip(some, predictions(own, tracks, candidates, near), strict=True):
            predicted[i] = p
    by = [p.by(columns) for p in predicted]
    both = [np.concatenate([p.by((EPS,)), s * b], axis=2) for p, b, s in zip(predicted, by, acts, strict=True)]
    evidence = of_windows(motion, predicted, both)
    step = evidence.solve(range(both[0].shape[2]))[0]
    change = x[1:] - _rest(cause, 0.0)
    return Acting(change, tuple(predicted), tuple(by), float(evidence.constant.sum())), step


def _with(model: Model, cause: ActiveEffect | None, x: Floats) -> Model:
    """The model of trials in which the cause acts."""
    if cause is not None:
        return with_values(model, [cause], x, model.effects)
    eps = float(np.clip(x[0] + x[1], *model.medium.limits(LEAST_EPS, MOST_EPS)))
    return replace(model, medium=model.medium.with_ratio(eps))
