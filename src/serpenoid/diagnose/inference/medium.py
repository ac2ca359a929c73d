"""Fits on the stage of motion: every candidate is scored linearly, the best are fitted in full.

Legend: W windows of all trials, P columns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.geometry import turn
from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.data.windows import Prediction, Track, predictions
from serpenoid.diagnose.inference.bounds import LEAST_EPS, MOST_EPS, at_values, held_at_bounds
from serpenoid.diagnose.inference.evidence import Evidence
from serpenoid.effects.active import ActiveEffect, joined
from serpenoid.effects.base import MediumEffect, Parameter
from serpenoid.effects.catalogue import catalogue
from serpenoid.files.store import remembered
from serpenoid.model import Model

STEPS = 8
TO_THE_END = 60  # steps of what was chosen: along curved valleys (eps against dry friction) eight are not enough
CONVERGED = 0.02  # chi squared


@dataclass(frozen=True)
class Fit:
    """A fitted model with its effects (frame_drift is one of them, though the model's motion does not know it).

    evidence: linearised about the fit; its columns: eps first, then each fitted effect's coordinates. held: how many of
    the model's effects, the first ones, were known and not fitted.
    """

    model: Model
    drift: ActiveEffect | None
    evidence: Evidence
    predictions: tuple[Prediction, ...]
    chi2: float
    held: int = 0

    @property
    def effects(self) -> tuple[ActiveEffect, ...]:
        """All that were fitted."""
        return (*self.model.effects[self.held :], *(() if self.drift is None else (self.drift,)))

    @property
    def coordinates(self) -> Floats:
        """eps and the coordinates of all fitted effects."""
        return _coordinates(self.model, self.effects)

    @property
    def converged(self) -> bool:
        """Whether another step would gain next to nothing."""
        return _at_the_end(self.evidence)

    def shrinking(self, evidence: Evidence) -> Evidence:
        """Evidence about this fit, whose first columns are its own, for fits without a gait."""
        rest = np.array([np.nan, *(_resting(p) for e in self.effects for p in e.effect.parameters)])
        return evidence.shrinking(range(len(rest)), np.zeros(len(rest)), rest - self.coordinates)


def with_values(
    model: Model, effects: Sequence[ActiveEffect], x: Floats, held: Sequence[ActiveEffect] = ()
) -> tuple[Model, ActiveEffect | None]:
    """Model (and drift) of eps and coordinates x (1 + P), after the held effects that are not among the fitted."""
    eps = float(np.clip(x[0], *model.medium.limits(LEAST_EPS, MOST_EPS)))
    found, drift, at = [], None, 1
    for e in effects:
        size = len(e.effect.parameters)
        new = e.with_coordinates(x[at : at + size].tolist())
        at += size
        if e.name == "frame_drift":
            drift = new
        elif e.name == "load":
            least = -float(model.body.vertex_weights[e.place or 0])
            new = e.with_coordinates([max(new.parameters["share"], least)])
            found.append(new)
        else:
            found.append(new)
    # a neutral value would drop the effect from the model, and with it the derivative
    kept = [_awake(e) for e in found]
    return Model(model.body, model.medium.with_ratio(eps), joined(held, kept)), drift


def _awake(effect: ActiveEffect) -> ActiveEffect:
    if not effect.is_neutral:
        return effect
    nudged = [c + 1e-9 * max(abs(p.coordinate(p.typical)), 1e-6) for c, p in
              zip(effect.coordinates, effect.effect.parameters, strict=False)]  # fmt: skip
    return effect.with_coordinates(nudged)


def drift_columns(track: Track) -> Floats:
    """Displacement of each window by a unit velocity of the frame, (B - 1, 3, 2)."""
    heading = track.poses[track.boundaries[:-1], 2]
    x = turn(-heading, np.tile([1.0, 0.0], (len(heading), 1))) * track.duration[:, None]
    y = turn(-heading, np.tile([0.0, 1.0], (len(heading), 1))) * track.duration[:, None]
    zero = np.zeros(len(heading))
    return np.stack([np.column_stack([x, zero]), np.column_stack([y, zero])], axis=2)


def linearised(
    motion: Motion,
    model: Model,
    effects: Sequence[ActiveEffect],
    drift: ActiveEffect | None,
    candidates: Sequence[ActiveEffect] = (),
    hold: bool = True,
    near: Sequence[Prediction] | None = None,
) -> tuple[Evidence, tuple[Prediction, ...], tuple[tuple[str, int | None], ...]]:
    """Evidence at a model: columns eps, then the effects in the order given, then candidates; and predictions.

    hold: without what sits at a bound and is pushed outwards. near: what a model much like this one predicts.
    """
    rows, columns, labels, found = [], [], [], []
    names: list[tuple[str, int | None]] = []
    listed = [*at_values(model, effects, drift), *candidates]
    inside = [c for c in candidates if isinstance(c.effect, MediumEffect)]
    plain = predictions(model, motion.tracks, inside, near)
    for track, label, p in zip(motion.tracks, motion.labels, plain, strict=True):
        by = {(c.effect, c.place, c.parameter): p.jacobian[..., i] for i, c in enumerate(p.columns)}
        own = drift_columns(track)
        velocity = np.array([drift.parameters["velocity_x"], drift.parameters["velocity_y"]]) if drift else np.zeros(2)
        moved = p.displacement + own @ velocity
        found.append(replace(p, displacement=moved))
        stacked, names = [by[None, None, "anisotropy_ratio"]], [("anisotropy_ratio", None)]
        for e in listed:
            for i, parameter in enumerate(e.effect.parameters):
                stacked.append(own[..., i] if e.name == "frame_drift" else by[e.name, e.place, parameter.name])
                names.append(e.key)
        use, noise = track.usable, motion.noise.of(track)
        jacobian = np.stack(stacked, axis=-1)
        good = use & np.isfinite(jacobian).all(axis=(1, 2)) & np.isfinite(moved).all(axis=1)
        rows.append(((track.displacement - moved) / noise)[good].ravel())
        columns.append((jacobian / noise[..., None])[good].reshape(-1, len(names)))
        labels.append(np.full(len(rows[-1]), label))
    joined = Evidence.of(np.concatenate(rows), np.concatenate(columns), np.concatenate(labels))
    evidence = held_at_bounds(model, listed, joined) if hold else joined
    return evidence, tuple(found), tuple(names)


@remembered
def fit(
    motion: Motion,
    start: Model,
    effects: Sequence[ActiveEffect],
    x: Floats,
    steps: int = STEPS,
    near: Sequence[Prediction] | None = None,
) -> Fit:
    """Levenberg-Marquardt in eps and the effects' coordinates from x (1 + P), bounded; near: see `linearised`."""
    effects = sorted(effects, key=lambda e: e.name == "frame_drift")
    model, drift = with_values(start, effects, x, motion.held)
    held = len(model.effects) - len(effects) + (drift is not None)
    evidence, predicted, _ = linearised(motion, model, effects, drift, near=near)
    x = _values(model.effects[held:], model, drift)
    best, damping = float(evidence.constant.sum()), 1e-4
    for _ in range(steps):
        if _at_the_end(evidence):
            break
        matrix, vector = evidence.matrix.sum(axis=0), evidence.vector.sum(axis=0)
        scale = np.sqrt(np.maximum(np.diag(matrix), 1e-12))
        regular = matrix / np.outer(scale, scale) + damping * np.eye(len(x))
        step = np.linalg.solve(regular, vector / scale) / scale
        trial, trial_drift = with_values(start, effects, x + step, motion.held)
        new, elsewhere, _ = linearised(motion, trial, effects, trial_drift, near=predicted)
        cost = float(new.constant.sum()) if new.count.sum() == evidence.count.sum() else np.inf
        if cost < best:
            gained = best - cost
            model, drift, evidence, predicted, best = trial, trial_drift, new, elsewhere, cost
            x, damping = _values(model.effects[held:], model, drift), max(damping / 10, 1e-9)
            if gained < CONVERGED * max(1.0, 1e-5 * best):
                break
        else:
            damping = max(damping, 1e-4) * 30
            if damping > 1e3:
                break
    found = Fit(model, drift, evidence, predicted, best, held)
    return replace(found, evidence=found.shrinking(evidence))


def _at_the_end(evidence: Evidence) -> bool:
    """Whether, to first order, no more can be gained than is worth a step."""
    left = float(evidence.constant.sum())
    return left - evidence.chi2(range(evidence.matrix.shape[1])) < CONVERGED * max(1.0, 1e-5 * left)


def _resting(p: Parameter) -> float:
    """The coordinate that changes nothing; NaN where there is none."""
    return np.nan if p.neutral is None else p.resting


def fit_guided(motion: Motion, found: Fit, steps: int = 3) -> Fit:
    """Another few steps from a fit, on other tracks or another noise."""
    return fit(motion, found.model, list(found.effects), found.coordinates, steps, found.predictions)


def fit_eps(motion: Motion, start: Model) -> Fit:
    """The plain calibration: eps alone, from the model's."""
    return fit(motion, start, [], np.array([start.medium.anisotropy_ratio]))


def fit_without(motion: Motion, found: Fit, effect: ActiveEffect) -> Fit:
    """A fit with one effect left out and everything else fitted again."""
    kept = _others(found, effect)
    return fit(motion, found.model, kept, _coordinates(found.model, kept), near=found.predictions)


def predicted_without(motion: Motion, found: Fit, effect: ActiveEffect) -> tuple[Prediction, ...]:
    """What a fit predicts with one effect taken out and nothing fitted again."""
    kept = _others(found, effect)
    model, drift = with_values(found.model, kept, _coordinates(found.model, kept), motion.held)
    return linearised(motion, model, kept, drift, near=found.predictions)[1]


def predicted_bare(motion: Motion, found: Fit) -> tuple[Prediction, ...]:
    """What a fit predicts with all its effects taken out and nothing fitted again."""
    model, _ = with_values(found.model, [], found.coordinates[:1], motion.held)
    return linearised(motion, model, [], None, near=found.predictions)[1]


def _others(found: Fit, effect: ActiveEffect) -> list[ActiveEffect]:
    return [e for e in found.effects if e.key != effect.key]


def _values(fitted: Sequence[ActiveEffect], model: Model, drift: ActiveEffect | None) -> Floats:
    return _coordinates(model, [*fitted, *(() if drift is None else (drift,))])


def _coordinates(model: Model, effects: Sequence[ActiveEffect]) -> Floats:
    """eps and the coordinates of effects, as fits take them (1 + P,)."""
    return np.array([model.medium.anisotropy_ratio, *(c for e in effects for c in e.coordinates[:-1])])


def candidates_of(base: Fit) -> list[ActiveEffect]:
    """Every medium effect at every place, and frame_drift, neutral; those held, as they are; not those fitted."""
    model, held = base.model, base.model.effects[: base.held]
    found = list(held)
    for kind in catalogue().values():
        if kind.name != "frame_drift" and not isinstance(kind, MediumEffect):
            continue
        if any(p.neutral is None for p in kind.parameters) or not kind.applies_to("diagnose"):
            continue
        places = range(model.body.vertices) if kind.place == "vertex" else [None]
        present = {e.key for e in (*held, *base.effects)}
        found += [ActiveEffect.neutral(kind.name, p) for p in places if (kind.name, p) not in present]
    return found
