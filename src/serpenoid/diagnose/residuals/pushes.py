"""Pushes in single trials: differences between two repeats that chance, as the other windows show it, does not make.

Settings differ in noise, and so do phases of a cycle: a difference is measured by the medians of its direction, setting
and phase, and the largest of all by the largest of normal draws that are measured alike. However many windows there
are, the rate of false alarms is the same. Like anything that is left, a push is spoken of where its trace in the path
stands above the noise level.

Legend: K differences of all settings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtri

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import LEFT
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.noise import FEW, window_noise
from serpenoid.diagnose.data.noise.paths import PathNoise, apart, path_noise
from serpenoid.diagnose.data.noise.repeats import repeats
from serpenoid.diagnose.data.windows.windows import Prediction

DRAWS = 600  # two of them are larger than the quantile
MEDIAN = 0.6745  # of |x| of a normal variable
MANY = 24  # numbers: a median of these is good to a fifth


@dataclass(frozen=True)
class Differences:
    """Of repeats over sqrt 2 while playing (K, 3); of each the track, its window, the setting and the phase (K,)."""

    values: Floats
    track: np.ndarray
    window: np.ndarray
    setting: np.ndarray
    phase: Floats

    @classmethod
    def of(cls, motion: Motion, left: Sequence[Floats]) -> Differences:
        """Settings with a few windows tell nothing."""
        kinds = {s: i for i, s in enumerate(dict.fromkeys(t.recording.setting for t in motion.tracks))}
        parts = []
        for repeat in repeats(motion.tracks):
            track, (one, other) = motion.tracks[repeat.one], repeat.both(left)
            d = (one - other) / np.sqrt(2)
            use = track.playing[repeat.here] & np.isfinite(d).all(axis=1)
            windows = repeat.here[use]
            labels = np.full((2, len(windows)), [[repeat.one], [kinds[track.recording.setting]]])
            parts.append(np.column_stack([d[use], labels[0], windows, labels[1], track.phase[windows]]))
        rows = np.concatenate(parts) if parts else np.empty((0, 7))
        counts = np.bincount(rows[:, 5].astype(int), minlength=len(kinds))
        rows = rows[counts[rows[:, 5].astype(int)] >= 2 * FEW]
        track, window, setting = rows[:, 3:6].T.astype(int)
        return cls(rows[:, :3], track, window, setting, rows[:, 6])

    def measured(self, values: Floats) -> Floats:
        """Sizes (..., K, 3) of differences (..., K, 3) by direction, then setting, then phase, where there are many."""
        sizes = _in_widths(np.abs(values), -2)
        for label in (self.setting, self.phase):
            for own in np.unique(label):
                mine = label == own
                if 3 * mine.sum() >= MANY:
                    sizes[..., mine, :] = _in_widths(sizes[..., mine, :], (-2, -1))
        return sizes


def pushed(motion: Motion, left: Sequence[Floats]) -> list[tuple[int, int, Floats]]:
    """Track, window and displacement (3,) of pushes that chance does not make, beyond what is no news."""
    found = Differences.of(motion, left)
    if not len(found.values):
        return []
    news = np.abs(found.values) > motion.unlike
    sizes = np.where(news, found.measured(found.values), 0.0).max(axis=1)
    if sizes.max() <= -ndtri(LEFT / (2 * found.values.size)):  # measured by their median, the largest are no smaller
        return []
    drawn = found.measured(np.random.default_rng(0).normal(size=(DRAWS, *found.values.shape))).max(axis=(1, 2))
    rows = np.flatnonzero(sizes > np.quantile(drawn, 1 - LEFT))
    return [(int(found.track[i]), int(found.window[i]), np.sqrt(2) * found.values[i]) for i in rows]


def calm(
    motion: Motion,
    predictions: Sequence[Prediction],
    left: Sequence[Floats],
    pushes: Sequence[tuple[int, int, Floats]],
) -> PathNoise:
    """Noise of paths, by the windows without pushes: what is news is no chance."""
    rest = [x.copy() for x in left]
    for track, window, _ in pushes:
        rest[track][window] = np.nan
    noise = window_noise(motion.tracks, rest)[0] if pushes else motion.noise
    return path_noise(replace(motion, noise=noise), predictions, rest)


def trace(motion: Motion, predictions: Sequence[Prediction], pushes: Sequence[tuple[int, int, Floats]]) -> float:
    """Path RMS [m] that pushes make of the trial that has most of them."""
    moved = {track: predictions[track].displacement.copy() for track, _, _ in pushes}
    for track, window, push in pushes:
        moved[track][window] += push
    return max((apart(motion.tracks[i], d, predictions[i].displacement) for i, d in moved.items()), default=0.0)


def _in_widths(sizes: Floats, axis: int | tuple[int, int]) -> Floats:
    """Sizes by the standard deviation that their median over `axis` tells."""
    width = np.median(sizes, axis=axis, keepdims=True) / MEDIAN
    return np.asarray(sizes / np.maximum(width, 1e-300))
