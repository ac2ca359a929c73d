"""Fits on the stage of motion: every candidate is scored linearly, the best are fitted in full.

Legend: W windows of all trials, P columns.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.windows.windows import Prediction, columns_of, predictions
from serpenoid.diagnose.inference.fits.bounds import LEAST_EPS, MOST_EPS, at_values, held_at_bounds
from serpenoid.diagnose.inference.fits.evidence import Evidence
from serpenoid.diagnose.inference.fits.prices import Priced
from serpenoid.effects.active import ActiveEffect, joined
from serpenoid.effects.base import Parameter
from serpenoid.effects.catalogue import motion_effects, of_laws, places
from serpenoid.files.store import remembered
from serpenoid.model import Model
from serpenoid.simulation.sensitivity import EPS

STEPS = 8
TO_THE_END = 60  # steps of what was chosen: along curved valleys (eps against dry friction) eight are not enough
CONVERGED = 0.02  # chi squared


@dataclass(frozen=True)
class Fit:
    """A fitted model with its effects, of the medium and of the cameras' frame.

    evidence: linearised about the fit; its columns: eps first, then each fitted effect's coordinates. held: how many of
    the model's effects, the first ones, were known and not fitted.
    """

    model: Model
    evidence: Evidence
    predictions: tuple[Prediction, ...]
    chi2: float
    held: int = 0

    @property
    def effects(self) -> tuple[ActiveEffect, ...]:
        """All that were fitted."""
        return self.model.effects[self.held :]

    @property
    def coordinates(self) -> Floats:
        """eps and the coordinates of all fitted effects."""
        return coordinates_of(self.model, self.effects)

    @property
    def priced(self) -> Priced:
        """What it leaves, by how many numbers."""
        return Priced(self.chi2, len(self.coordinates), float(self.evidence.count.sum()))

    @property
    def columns(self) -> list[range]:
        """Of each effect, which columns of the evidence are its own."""
        ends = np.cumsum([1, *(len(e.effect.parameters) for e in self.effects)]).tolist()
        return [range(a, b) for a, b in zip(ends[:-1], ends[1:], strict=True)]

    @property
    def converged(self) -> bool:
        """Whether, to first order, no more can be gained than is worth a step."""
        least = self.evidence.chi2(range(self.evidence.matrix.shape[1]))
        return bool(self.chi2 - least < CONVERGED * max(1.0, 1e-5 * self.chi2))

    def away_from(self, model: Model) -> float:
        """How many standard deviations its parameters are from those of a model; what that lacks is neutral there.

        By curvature, and wider where more than chance is left.
        """
        there = {e.key: e for e in model.effects}
        others = [there.get(e.key, ActiveEffect.neutral(e.name, e.place)) for e in self.effects]
        apart = self.coordinates - coordinates_of(model, others)
        spread = max(1.0, self.chi2 / float(self.evidence.count.sum()))
        return float(np.sqrt(apart @ self.evidence.matrix.sum(axis=0) @ apart / spread))

    def shrinking(self, evidence: Evidence, motion: Motion) -> Evidence:
        """Evidence about this fit to a motion, whose first columns are its own, for fits without a gait."""
        rest = np.array([np.nan, *(x for e in self.effects for x in _resting(motion, e))])
        return evidence.shrinking(range(len(rest)), np.zeros(len(rest)), rest - self.coordinates)


def with_values(model: Model, effects: Sequence[ActiveEffect], x: Floats, held: Sequence[ActiveEffect] = ()) -> Model:
    """Model of eps and coordinates x (1 + P), after the held effects that are not among the fitted."""
    eps = float(np.clip(x[0], *model.medium.limits(LEAST_EPS, MOST_EPS)))
    ends = np.cumsum([1, *(len(e.effect.parameters) for e in effects)])
    # a neutral value would drop the effect from the model, and with it the derivative
    fitted = [_awake(e.on_body(model.body, x[a:b].tolist())) for e, a, b in zip(effects, ends, ends[1:], strict=False)]
    return Model(model.body, model.medium.with_ratio(eps), joined(held, fitted))


def _awake(effect: ActiveEffect) -> ActiveEffect:
    if not effect.is_neutral:
        return effect
    parameters = effect.effect.parameters
    return effect.with_coordinates([c + _nudge(p) for c, p in zip(effect.coordinates, parameters, strict=False)])


def _nudge(p: Parameter) -> float:
    """So little that it changes nothing."""
    return 1e-9 * max(abs(p.coordinate(p.typical)), 1e-6)


def moved(motion: Motion, found: Fit, column: int) -> bool:
    """Whether a coordinate of a fit is not where its effect changes nothing."""
    p = [p for e in found.effects for p in e.effect.parameters][column - 1]
    rest = [x for e in found.effects for x in motion.unchanged(e)][column - 1]
    return bool(abs(found.coordinates[column] - rest) > 2 * _nudge(p))


def linearised(
    motion: Motion,
    model: Model,
    effects: Sequence[ActiveEffect],
    candidates: Sequence[ActiveEffect] = (),
    hold: bool = True,
    near: Sequence[Prediction] | None = None,
) -> tuple[Evidence, tuple[Prediction, ...]]:
    """Evidence at a model: columns eps, then the effects in the order given, then candidates; and predictions.

    hold: without what sits at a bound and is pushed outwards. near: what a model much like this one predicts.
    """
    listed = [*at_values(model, effects), *candidates]
    found = predictions(model, motion.tracks, candidates, near)
    joined = of_windows(motion, found, [p.by((EPS, *columns_of(listed))) for p in found])
    evidence = held_at_bounds(model, listed, joined) if hold else joined
    return evidence, tuple(found)


def of_windows(motion: Motion, found: Sequence[Prediction], by: Iterable[Floats]) -> Evidence:
    """Evidence of what all windows leave beside predictions; by: derivatives (W, 3, P) of each track's windows."""
    rows, columns, labels = [], [], []
    for number, (label, p, d) in enumerate(zip(motion.labels, found, by, strict=True)):
        own, slopes = of_trial(motion, number, p, d)
        rows.append(own)
        columns.append(slopes)
        labels.append(np.full(len(own), label))
    return Evidence.of(np.concatenate(rows), np.concatenate(columns), np.concatenate(labels))


def of_trial(motion: Motion, number: int, predicted: Prediction, by: Floats) -> tuple[Floats, Floats]:
    """White residuals (R,) of one track's windows beside a prediction, and columns (R, P), eps first; by: see
    `of_windows`."""
    track, white = motion.tracks[number], motion.white[number]
    known = track.usable & np.isfinite(by).all(axis=(1, 2)) & np.isfinite(predicted.displacement).all(axis=1)
    columns = white.of(by, known)
    if motion.ratio_held:
        columns[:, 0] = 0.0
    return white.of(track.displacement - predicted.displacement, known), columns


@remembered
def fit(
    motion: Motion,
    start: Model,
    effects: Sequence[ActiveEffect],
    x: Floats,
    steps: int = STEPS,
    near: Sequence[Prediction] | None = None,
    least: float = 0.0,
) -> Fit:
    """Levenberg-Marquardt in eps and the effects' coordinates from x (1 + P), bounded; near: see `linearised`.

    least: where fewer residuals have roots at the start, it is no fit and stays there: no step finds others.
    """
    model = with_values(start, effects, x, motion.held)
    evidence, predicted = linearised(motion, model, effects, near=near)
    begun = Fit(model, evidence, predicted, float(evidence.constant.sum()), len(model.effects) - len(effects))
    return _descended(motion, begun, steps if evidence.count.sum() >= least else 0)


@remembered
def fit_on(motion: Motion, found: Fit, steps: int) -> Fit:
    """Another few steps from a fit to the same windows."""
    return _descended(motion, found, steps)


def _descended(motion: Motion, found: Fit, steps: int) -> Fit:
    damping, effects = 1e-4, list(found.effects)
    for _ in range(steps):
        if found.converged:
            break
        matrix, vector = found.evidence.matrix.sum(axis=0), found.evidence.vector.sum(axis=0)
        scale = np.sqrt(np.maximum(np.diag(matrix), 1e-12))
        regular = matrix / np.outer(scale, scale) + damping * np.eye(len(vector))
        step = np.linalg.solve(regular, vector / scale) / scale
        trial = with_values(found.model, effects, found.coordinates + step, motion.held)
        new, elsewhere = linearised(motion, trial, effects, near=found.predictions)
        cost = float(new.constant.sum()) if new.count.sum() == found.evidence.count.sum() else np.inf
        if cost < found.chi2:
            gained = found.chi2 - cost
            found, damping = Fit(trial, new, elsewhere, cost, found.held), max(damping / 10, 1e-9)
            if gained < CONVERGED * max(1.0, 1e-5 * cost):
                break
        else:
            damping = max(damping, 1e-4) * 30
            if damping > 1e3:
                break
    return replace(found, evidence=found.shrinking(found.evidence, motion))


def _resting(motion: Motion, effect: ActiveEffect) -> list[float]:
    """Its coordinates that change nothing; NaN where there is none."""
    pairs = zip(effect.effect.parameters, motion.unchanged(effect), strict=True)
    return [np.nan if p.neutral is None else x for p, x in pairs]


def fit_guided(motion: Motion, found: Fit, steps: int = 3) -> Fit:
    """Another few steps from a fit, on other tracks or another noise."""
    return fit(motion, found.model, list(found.effects), found.coordinates, steps, found.predictions)


def fit_eps(motion: Motion, start: Model, near: Sequence[Prediction] | None = None) -> Fit:
    """The plain calibration: eps alone, from the model's; near: see `linearised`."""
    return fit(motion, start, [], np.array([start.medium.anisotropy_ratio]), near=near)


def fit_without(motion: Motion, found: Fit, effect: ActiveEffect) -> Fit:
    """A fit with one effect left out and everything else fitted again."""
    kept = _others(found, effect)
    return fit(motion, found.model, kept, coordinates_of(found.model, kept), near=found.predictions)


def predicted_without(motion: Motion, found: Fit, effect: ActiveEffect) -> tuple[Prediction, ...]:
    """What a fit predicts with one effect taken out and nothing fitted again."""
    kept = _others(found, effect)
    model = with_values(found.model, kept, coordinates_of(found.model, kept), motion.held)
    return linearised(motion, model, kept, near=found.predictions)[1]


def predicted_bare(motion: Motion, found: Fit, kept: Sequence[ActiveEffect] = ()) -> tuple[Prediction, ...]:
    """What a fit predicts with its effects, but for those kept, taken out and nothing fitted again."""
    model = with_values(found.model, kept, coordinates_of(found.model, kept), motion.held)
    return linearised(motion, model, kept, near=found.predictions)[1]


def _others(found: Fit, effect: ActiveEffect) -> list[ActiveEffect]:
    return [e for e in found.effects if e.key != effect.key]


def coordinates_of(model: Model, effects: Sequence[ActiveEffect]) -> Floats:
    """eps and the coordinates of effects, as fits take them (1 + P,)."""
    return np.array([model.medium.anisotropy_ratio, *(c for e in effects for c in e.coordinates[:-1])])


def candidates_of(base: Fit) -> list[ActiveEffect]:
    """Every effect that the motion shows, at every place, neutral; those held, as they are; not those fitted, nor what
    is the same under another name on another kind of body, nor the law's own numbers."""
    model, held = base.model, base.model.effects[: base.held]
    found, present = [e for e in held if e.effect not in of_laws()], {e.key for e in model.effects}
    for kind in motion_effects():
        if kind.scan is None and model.body.other_surface not in kind.needs:
            found += [
                ActiveEffect.neutral(kind.name, p) for p in places(kind, model.body) if (kind.name, p) not in present
            ]
    return found
