"""Steps of position across gaps: what the model does not account for between the last marker seen and the next.

A jump has a length and a direction of its own at every gap; residuals there are Rice distributed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from scipy.special import ive

from serpenoid.diagnose.data.chance import NORMAL, SYSTEMATIC
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.paths import gap_steps
from serpenoid.diagnose.data.windows.windows import Prediction
from serpenoid.diagnose.inference.fits.finding import Named, interval
from serpenoid.diagnose.inference.fits.prices import most_gained
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.catalogue import marking

MEAN_SHARE = 0.42  # path RMS of a jump somewhere in the middle, over its length, start pose fitted


def gap_lengths(
    motion: Motion, predictions: Sequence[Prediction], missed_m: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Lengths of unaccounted displacement across gaps [m], and the SD of one component without steps [m]: noise, and in
    each window the discrepancy `missed_m` that windows without gaps leave.
    """
    lengths, noises = [], []
    for track, p in zip(motion.tracks, predictions, strict=True):
        noise = motion.noise.of(track)
        for first, last, step in gap_steps(track, p):
            lengths.append(np.hypot(step[0], step[1]))
            chance = (noise[first:last, :2] ** 2).sum() / 2
            noises.append(np.sqrt(chance + ((last - first) * missed_m) ** 2 / 2))
    return np.array(lengths), np.array(noises)


def find_jumps(
    motion: Motion, predictions: Sequence[Prediction], noise_level_m: float, missed_m: float = 0.0, tries: int = 1
) -> Named | None:
    """Steps across gaps, if they show them; missed_m: see `gap_lengths`; tries: candidates that might be named."""
    kind = next((k for k in marking("jumps") if k.name not in motion.untestable), None)
    found = None if kind is None else length_of_steps(motion, predictions, missed_m, tries)
    if kind is None or found is None:
        return None
    size, ends = found
    (parameter,) = kind.parameters
    effect = ActiveEffect.neutral(kind.name).with_coordinates([size])
    return Named(effect, {parameter.name: interval(ends)}, MEAN_SHARE * size / noise_level_m)


def length_of_steps(
    motion: Motion, predictions: Sequence[Prediction], missed_m: float = 0.0, tries: int = 1
) -> tuple[float, list[float]] | None:
    """Length [m] and its 95 % interval; None where gaps show no more than chance."""
    lengths, noises = gap_lengths(motion, predictions, missed_m)
    if len(lengths) < 3:
        return None

    def log_likelihood(size: float) -> float:
        z = lengths * size / noises**2
        return float((np.log(ive(0, z)) + z - (lengths**2 + size**2) / (2 * noises**2)).sum())

    most = float(lengths.max() + 3 * noises.max())
    options = {"xatol": 1e-3 * float(noises.min())}
    found = minimize_scalar(lambda x: -log_likelihood(x), bounds=(0.0, most), method="bounded", options=options)
    size = float(found.x)
    best = log_likelihood(size)
    if 2 * (best - log_likelihood(0.0)) < most_gained(1, tries):
        return None
    drop = (NORMAL * SYSTEMATIC) ** 2 / 2
    return size, [brentq(lambda x: log_likelihood(x) - best + drop, size, end) for end in (0.0, size + 2 * most)]
