"""Which effects of the medium (and steps or drift of the camera frame) the motion shows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.diagnose.baseline import Baseline
from serpenoid.diagnose.finding import Named, Rung, interval
from serpenoid.diagnose.groups import Swap, groups, without
from serpenoid.diagnose.jumps import find_jumps
from serpenoid.diagnose.medium import Fit, Motion, Noise, fit
from serpenoid.diagnose.noise import path_rms, residuals, strength, total, window_noise
from serpenoid.diagnose.observation import Observation
from serpenoid.diagnose.recording import Recording
from serpenoid.diagnose.residual_words import pattern
from serpenoid.diagnose.select import Selection, select
from serpenoid.diagnose.windows import Track, make_tracks
from serpenoid.effects.active import ActiveEffect
from serpenoid.model import Model

GUESS = Noise(np.array([5e-4, 5e-4, 1e-3]), np.array([1e-4, 1e-4, 3e-4]))
QUANTILE = 2.05  # normal, a little more for a noise that is itself estimated
RELATIVE = 3e-3  # what smoothing the shapes leaves
SYSTEMATIC = 1.15  # noise of shapes, alike in all trials of a gait


@dataclass(frozen=True)
class MotionFinding:
    """The rung's finding and everything it rests on."""

    rung: Rung
    selection: Selection
    swaps: tuple[Swap, ...]
    before_m: float
    after_m: float


def choose_motion(
    recordings: Sequence[Recording], seen: Observation, baseline: Baseline, say: Callable[[str], None]
) -> MotionFinding:
    """Calibrate eps, select effects, say what is left."""

    def tracks(about: Model) -> tuple[Track, ...]:
        return baseline.corrected(make_tracks(recordings, seen, about))

    model = baseline.model
    gaits = {name: i for i, name in enumerate(dict.fromkeys(r.gait for r in recordings))}
    labels = tuple(gaits[r.gait] for r in recordings)
    for _ in range(2):
        motion = Motion(tracks(model), GUESS, labels, baseline.model.effects, baseline.unlike)
        model = fit(motion, model, [], np.array([model.medium.anisotropy_ratio])).model
    return finding(select(motion, model, tracks, say))


def finding(found: Selection) -> MotionFinding:
    """The selection in words and intervals."""
    motion, best, floor = found.motion, found.best, found.floor_m
    before = total([path_rms(t, p) for t, p in zip(motion.tracks, found.null.predictions, strict=True)])
    after = total([path_rms(t, p) for t, p in zip(motion.tracks, best.predictions, strict=True)])
    bases = [without(found, e) for e in best.effects]
    named = [named_of(found, base, e) for e, base in zip(best.effects, bases, strict=True)]
    swaps = groups(found, bases)
    jumps = find_jumps(motion, best.predictions, floor)
    faint = [t.added for t in found.faint]
    if jumps is not None and jumps.strength >= 1.6:
        named.append(jumps)
        after = total([path_rms(t, p, mend=True) for t, p in zip(motion.tracks, best.predictions, strict=True)])
    elif jumps is not None:
        faint.append(jumps.effect)
    words = _left_over(found, after)
    rung = Rung("motion", tuple(named), tuple(s.rival for s in swaps), tuple(faint), after / floor, words)
    return MotionFinding(rung, found, swaps, before, after)


def _left_over(found: Selection, after_m: float) -> tuple[str, ...]:
    """What neither the effects named nor one too faint to be named account for."""
    motion, predictions = found.motion, found.best.predictions
    if found.faint:
        predictions = found.faint[-1].fit.predictions
        after_m = min(after_m, total([path_rms(t, p) for t, p in zip(motion.tracks, predictions, strict=True)]))
    _, differences = window_noise(motion.tracks, residuals(motion.tracks, predictions))
    return pattern(motion, predictions, after_m / found.floor_m, differences)


def named_of(found: Selection, base: Fit, effect: ActiveEffect) -> Named:
    """Intervals from the curvature, strength from what the path loses without the effect (`base`)."""
    best = found.best
    _, covariance = best.evidence.solve(range(len(best.coordinates)))
    spread = SYSTEMATIC * max(1.0, np.sqrt(best.chi2 / best.evidence.count.sum()))
    at = 1
    for e in best.effects:
        if e is effect:
            break
        at += len(e.effect.parameters)
    ends, bound = {}, []
    for i, p in enumerate(effect.effect.parameters):
        x = effect.coordinates[i]
        half = QUANTILE * spread * float(np.sqrt(covariance[at + i, at + i])) + RELATIVE * abs(x)
        ends[p.name] = interval(
            [_clipped(p.value(x - half), p.lower, p.upper), _clipped(p.value(x + half), p.lower, p.upper)]
        )
        value = effect.parameters[p.name]
        if value <= p.lower + 1e-6 * abs(p.typical) or value >= p.upper - 1e-6 * abs(p.typical):
            bound.append(p.name)
    return Named(effect, ends, strength(found.motion, best.predictions, base.predictions) / found.floor_m, tuple(bound))


def _clipped(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)
