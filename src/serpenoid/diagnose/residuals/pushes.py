"""Pushes in single trials: differences between two repeats that chance, as the other windows show it, does not make.

Settings differ in noise, and so do phases of a cycle: a difference is measured by the medians of its direction, setting
and phase, and the largest of all by the largest of normal draws that are measured alike. However many windows there
are, the rate of false alarms is the same.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.data.noise import FEW, pairs

DRAWS, ERROR = 200, 0.01
CLEAR = 5.0  # standard deviations: noise is only about normal
MEDIAN = 0.6745  # of |x| of a normal variable


def pushed(motion: Motion, left: Sequence[Floats]) -> bool:
    """Whether repeats differ by pushes, beyond what is no news."""
    found = _differences(motion, left)
    if not found:
        return False
    phases = [p for _, p in found]
    rng = np.random.default_rng(0)
    drawn = _measured([rng.normal(size=(DRAWS, *d.shape)) for d, _ in found], phases).max(axis=(1, 2))
    news = np.concatenate([np.abs(d) for d, _ in found]) > motion.unlike
    largest = np.where(news, _measured([d for d, _ in found], phases), 0.0).max()
    return bool(largest > max(CLEAR, np.quantile(drawn, 1 - ERROR)))


def _measured(settings: Sequence[Floats], phases: Sequence[Floats]) -> Floats:
    """Sizes (..., N, 3) of the differences (..., K, 3) of all settings, by direction, setting and phase."""
    setting = np.repeat(np.arange(len(settings)), [d.shape[-2] for d in settings])
    phase = np.concatenate(phases)
    sizes = np.abs(np.concatenate(settings, axis=-2))
    sizes = _in_widths(sizes, -2)
    for label in (setting, phase):
        for own in np.unique(label):
            sizes[..., label == own, :] = _in_widths(sizes[..., label == own, :], (-2, -1))
    return sizes


def _in_widths(sizes: Floats, axis: int | tuple[int, int]) -> Floats:
    """Sizes by the standard deviation that their median over `axis` tells."""
    width = np.median(sizes, axis=axis, keepdims=True) / MEDIAN
    return np.asarray(sizes / np.maximum(width, 1e-300))


def _differences(motion: Motion, left: Sequence[Floats]) -> list[tuple[Floats, Floats]]:
    """Of each setting: differences of repeats over sqrt 2 while playing (K, 3), and their phases (K,)."""
    by: dict[tuple[str, float], list[tuple[Floats, Floats]]] = {}
    for a, b in pairs(motion.tracks):
        n = min(len(left[a]), len(left[b]))
        d = (left[a][:n] - left[b][:n]) / np.sqrt(2)
        use = motion.tracks[a].playing[:n] & np.isfinite(d).all(axis=1)
        by.setdefault(motion.tracks[a].recording.setting, []).append((d[use], motion.tracks[a].phase[:n][use]))
    joined = [(np.concatenate([d for d, _ in s]), np.concatenate([p for _, p in s])) for s in by.values()]
    return [(d, p) for d, p in joined if len(d) >= 2 * FEW]
