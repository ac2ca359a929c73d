"""The rate between two devices' clocks: one that is more than chance in all trials, or another in some of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import NORMAL, SYSTEMATIC
from serpenoid.diagnose.data.recordings.clocks import pooled, run_apart
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.inference.fits.finding import VISIBLE, Divided, Named, interval
from serpenoid.diagnose.stages.by_trial import divided
from serpenoid.diagnose.stages.observation.looked import Looked
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import Effect
from serpenoid.effects.catalogue import marking


def rate_of_all(recordings: Sequence[Recording], best: Looked, known: tuple[float, float] = (0.0, 0.0)) -> Named | None:
    """The rate between two clocks, if it is another one than before by more than chance; known: that rate and its
    deviation."""
    kind, (before, before_sd) = _kind(best), known
    rate, sd = pooled([r.clock for r in recordings])
    if kind is None or ((rate - before) / np.hypot(sd, before_sd)) ** 2 < best.needed:
        return None
    (parameter,) = kind.parameters
    half = NORMAL * SYSTEMATIC * sd + parameter.resolution
    effect = ActiveEffect.neutral(kind.name).with_coordinates([rate])
    ends = {parameter.name: interval((rate - half, rate + half))}
    was = {parameter.name: before} if before else {}
    return Named(effect, ends, abs(rate - before) * _visible(best, recordings), before=was)


def rates_by_trial(recordings: Sequence[Recording], best: Looked) -> Divided | None:
    """The rate between two clocks, where it differs from trial to trial by what is visible: as where a device was
    started anew, or another one was taken."""
    kind = _kind(best)
    clocks = [r.clock for r in recordings]
    if kind is None or not run_apart(clocks, [r.setting for r in recordings]):
        return None
    rates = np.array([c.rate for c in clocks])
    off = np.abs(rates - pooled(clocks)[0])
    drifted = max(x * _visible(best, [r]) for r, x in zip(recordings, off, strict=True))
    if drifted < VISIBLE:
        return None
    effects = [ActiveEffect.neutral(kind.name).with_coordinates([rate]) for rate in rates]
    ends = f"from {rates.min():+.3g} to {rates.max():+.3g} s/s"
    told = divided(effects, [r.name for r in recordings], f"clocks run at another rate in each trial, {ends}")
    return replace(told, any_gait=True)


def _kind(best: Looked) -> Effect | None:
    """The catalogue's effect of such a rate, unless it is left out."""
    return next((k for k in marking("rate") if k.name not in best.without), None)


def _visible(best: Looked, recordings: Sequence[Recording]) -> float:
    """What a clock that is off by 1 s/s makes of the angles of some trials, over the noise level of the worst joint."""
    levels = best.data.levels[: best.data.body.joint_count]
    squares = np.mean([_drifted(r) for r in recordings], axis=0)
    return float((np.sqrt(squares) / levels).max())


def _drifted(r: Recording) -> Floats:
    inside = (r.time > 0) & (r.time < r.end)
    speed = np.gradient(r.angles, r.time, axis=0)[inside]
    late = r.time[inside] - r.time[inside].mean()
    return np.asarray(((speed * late[:, None]) ** 2).mean(axis=0))
