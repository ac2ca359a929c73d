"""What chance does: differences between repeats, which no law of the robot or the floor can explain.

Window noise: SD of the difference of two repeats' residuals over sqrt 2 (repeats.py: trials, or cycles of a trial).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.noise.memory import Memory
from serpenoid.diagnose.data.noise.motion import Motion, Noise
from serpenoid.diagnose.data.noise.repeats import repeats
from serpenoid.diagnose.data.shapes.geometry import GYRATION
from serpenoid.diagnose.data.windows.windows import Prediction, Track
from serpenoid.measure.logs import TICK

CREEP_TICKS = 0.1  # shapes settle in pauses by less than a servo's tick, alike in repeats
FEW = 4  # windows: a variance of fewer tells nothing


def residuals(tracks: Sequence[Track], predictions: Sequence[Prediction]) -> list[Floats]:
    """Measured minus predicted displacement of each window (B - 1, 3), NaN where not usable."""
    return [
        np.where(t.usable[:, None], t.displacement - p.displacement, np.nan)
        for t, p in zip(tracks, predictions, strict=True)
    ]


def window_noise(tracks: Sequence[Track], left: Sequence[Floats]) -> tuple[Noise, Floats]:
    """Noise of the windows, and differences over sqrt 2 while playing (K, 3).

    Where not even a cycle was played again, the residuals' own scatter is all there is, and there are no differences;
    nor are there any of tracks that bring their own noise.
    """
    own = [t.noise for t in tracks if t.noise is not None]
    if own:
        typical = np.sqrt((np.concatenate(own) ** 2).mean(axis=0))
        return Noise(typical, typical, memory=Memory.of_poses()), np.empty((0, 3))
    least = np.sqrt(np.mean([np.mean(np.square(t.least), axis=0) * np.ones(3) for t in tracks], axis=0))
    creep = CREEP_TICKS * TICK * np.array([*[GYRATION * tracks[0].recording.body.total_length_m] * 2, 1.0])
    again = repeats(tracks)
    if not again:
        moved, rested = (_finite([x[t.playing == p] for t, x in zip(tracks, left, strict=True)]) for p in (True, False))
        return Noise(_sd(moved, least), np.hypot(_sd(rested, least), creep)), np.empty((0, 3))
    by: dict[tuple[str, float], list[Floats]] = {}
    rests = []
    for repeat in again:
        track, (one, other) = tracks[repeat.one], repeat.both(left)
        d, playing = (one - other) / np.sqrt(2), track.playing[repeat.here]
        by.setdefault(track.recording.setting, []).append(d[playing])
        rests.append(d[~playing])
    differences = {setting: _finite(found) for setting, found in by.items()}
    moved = np.concatenate(list(differences.values()))
    noise = Noise(_sd(moved, least), np.hypot(_sd(_finite(rests), least), creep), _each(differences, least))
    memory = Memory.told(tracks, again, left, [noise.chance(t) for t in tracks])
    alone = {t.recording.setting: 1 / memory.common(t, noise.chance(t)) for t in tracks}
    return replace(noise, by_setting=_each(differences, least, alone), memory=memory), moved


def over_markers(motion: Motion) -> float | None:
    """How many times as much windows' displacements differ by chance as the markers' own noise makes them (RMS while
    playing); None where markers have no noise. Where nothing was played again that is what the model leaves."""
    if any(t.noise is not None for t in motion.tracks):
        return None
    chance, least = (
        np.concatenate([np.broadcast_to(of(t), t.displacement.shape)[t.playing, :2] for t in motion.tracks])
        for of in (motion.noise.chance, lambda t: t.least)
    )
    return float(np.sqrt((chance**2).sum() / (least**2).sum())) if least.any() else None


def noise_uncertain(motion: Motion) -> float:
    """Standard deviation of the logarithm of a noise level: told by the windows that were played again, or by all, as
    many as they are worth."""
    told = [(motion.tracks[r.one], len(r.here)) for r in repeats(motion.tracks)]
    told = told or [(t, len(t.usable)) for t in motion.tracks]
    worth = sum(count / motion.noise.memory.common(t, motion.noise.chance(t)) for t, count in told)
    return float(1 / np.sqrt(2 * max(worth, 1.0)))


def _finite(parts: Sequence[Floats]) -> Floats:
    joined = np.concatenate(parts)
    return np.asarray(joined[np.isfinite(joined).all(axis=1)])


def _sd(values: Floats, least: Floats) -> Floats:
    if len(values) < FEW:
        return least.copy()
    return np.maximum(np.sqrt((values**2).mean(axis=0)), least)


def _each(
    differences: dict[tuple[str, float], Floats], least: Floats, alone: Mapping[tuple[str, float], float] | None = None
) -> dict[tuple[str, float], Floats]:
    """Noise of each setting (3,): its own mean square drawn to that of all, as far as settings are alike.

    Settings whose true variances scatter by tau (of their logarithm) are worth 2 / tau^2 degrees of freedom to one
    another; what scatters more than chance, 2 / n, tells tau. alone: how many independent numbers one of a setting's is
    worth (1).
    """
    many = {setting: d for setting, d in differences.items() if len(d) >= FEW}
    if len(many) < 2:
        return {}
    counts = np.array([len(d) * (alone[setting] if alone else 1.0) for setting, d in many.items()])
    squares = np.maximum([(d**2).mean(axis=0) for d in many.values()], least**2)
    pooled = (counts[:, None] * squares).sum(axis=0) / counts.sum()
    scatter = ((np.log(squares) - np.log(squares).mean(axis=0)) ** 2).sum() / (3 * (len(many) - 1))
    excess = max(scatter - float((2 / counts).mean()), 0.0)
    worth = 2 / excess if excess > 0 else np.inf
    share = np.array([1.0 if np.isinf(worth) else worth / (worth + n) for n in counts])[:, None]
    variances = share * pooled + (1 - share) * squares
    return {setting: np.sqrt(v) for setting, v in zip(many, variances, strict=True)}
