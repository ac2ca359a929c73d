"""What trials that were not laid alike differ by, beyond chance: the room, which the model lacks, or what differs from
trial to trial. Nobody can tell the two apart.

Cycles of one trial lie alike, or nearly so. In each setting and direction the variance of differences between trials
is held against that between cycles. Where trials have one cycle it is held against the markers' own noise, if repeats
exclude that what they differ by is forgotten at once (memory.py), as pushes are and the room is not. Logarithms of the
ratios are averaged, each as often as its numbers make it certain, so a setting that is noisier than others is compared
with itself. The mean exceeds a quantile of its normal distribution with a stated probability. What repeats of a
reference already differed by is no news.

Legend: K differences of a setting, S settings, W windows of a track.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import GAUSSIAN, largest_factor
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.noise import FEW
from serpenoid.diagnose.data.noise.repeats import Repeat, by_setting, cycles, none_alike, repeats
from serpenoid.diagnose.data.shapes.geometry import way

TINY = 1e-30  # [m^2, rad^2]: of markers without noise


@dataclass(frozen=True)
class Untold:
    """How many times as much trials differ (RMS) as cycles do, or, if not `by_cycles`, as the markers' noise makes
    them; size: what is beyond that of a window's displacement, RMS [m]."""

    ratio: float
    by_cycles: bool
    size: float


@dataclass(frozen=True)
class _Variances:
    """Mean squares (S, 3) of settings' differences, and how many independent normal numbers each is worth (S,)."""

    squares: Floats
    worth: Floats

    @classmethod
    def of(cls, motion: Motion, parts: Sequence[Floats]) -> _Variances:
        """Of differences (K, 3) of each setting: worth the fewer, the longer chance lasts and the heavier its tails."""
        squares = np.stack([(d**2).mean(axis=0) for d in parts])
        fourth = [(d**4).mean(axis=0) / np.maximum(v, TINY) ** 2 for d, v in zip(parts, squares, strict=True)]
        tails = max(float(np.mean(fourth)) / GAUSSIAN, 1.0)
        common = [motion.noise.memory.common(t, motion.noise.chance(t)) for t in motion.tracks]
        return cls(squares, np.array([len(d) for d in parts]) / (tails * float(np.mean(common))))


def untold(motion: Motion, left: Sequence[Floats]) -> Untold | None:
    """By residuals (W, 3) of each track; None where repeats were laid alike, or differ by no more than chance makes."""
    if any(t.noise is not None for t in motion.tracks) or not none_alike(motion.tracks):
        return None
    settings, played_again = list(by_setting(motion.tracks).values()), repeats(motion.tracks)
    trials = [_differences(motion, left, [r for r in played_again if r.one in own]) for own in settings]
    again = [_differences(motion, left, [r for i in own for r in cycles(motion.tracks, i)]) for own in settings]
    by_cycles = any(len(c) >= FEW for c in again)
    if not by_cycles and not motion.noise.memory.lasts:
        return None
    known = [i for i, d in enumerate(trials) if min(len(d), len(again[i]) if by_cycles else len(d)) >= FEW]
    if not known:
        return None
    between = _Variances.of(motion, [np.where(np.abs(trials[i]) > motion.unlike, trials[i], 0.0) for i in known])
    markers = np.stack([_of_markers(motion, settings[i]) for i in known])
    within = _Variances(markers, np.full(len(known), np.inf))
    if by_cycles:
        within = _Variances.of(motion, [again[i] for i in known])
    more = np.maximum(between.squares, markers) / np.maximum(within.squares, markers)
    certain = np.repeat(1 / (2 / between.worth + 2 / within.worth), 3)
    ratio = float(np.exp(np.average(np.log(more).ravel(), weights=certain) / 2))
    if ratio <= largest_factor(float(1 / np.sqrt(certain.sum())) / 2):
        return None
    beyond = np.maximum(between.squares - within.squares, 0.0).mean(axis=0)
    return Untold(ratio, by_cycles, way(motion.tracks[0].recording.body, beyond))


def _differences(motion: Motion, left: Sequence[Floats], again: Sequence[Repeat]) -> Floats:
    """Over sqrt 2 while playing (K, 3), of residuals that are both known."""
    parts = [np.empty((0, 3))]
    for repeat in again:
        one, other = repeat.both(left)
        parts.append(((one - other) / np.sqrt(2))[motion.tracks[repeat.one].playing[repeat.here]])
    joined = np.concatenate(parts)
    return np.asarray(joined[np.isfinite(joined).all(axis=1)])


def _of_markers(motion: Motion, trials: Sequence[int]) -> Floats:
    """Mean squares (3,) that the markers' own noise makes of windows while playing."""
    own = [motion.tracks[i] for i in trials]
    squares = [np.broadcast_to(t.least, t.displacement.shape)[t.playing] ** 2 for t in own]
    return np.maximum(np.concatenate(squares).mean(axis=0), TINY)
