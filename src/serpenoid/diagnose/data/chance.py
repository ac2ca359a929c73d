"""The stated errors, and what chance alone makes at these: whatever is held against chance is held against them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtri, ndtri

from serpenoid.body import Floats

ERROR = 0.01  # false alarms of a test: stated
LEFT = ERROR / 3  # of each way to ask whether chance is all that is left: what repeats share, where paths end, pushes
CONFIDENCE = 0.95  # of an interval: stated
NORMAL = 1.96  # standard deviations that it reaches
GAUSSIAN = 3.0  # fourth moment over the squared second
SYSTEMATIC = 1.15  # noise of shapes, a little of which is alike in all trials of a gait, beside what repeats tell


def largest_ratio(degrees: float) -> float:
    """Ratio that two mean squares of so many numbers each exceed by chance with probability LEFT (Fisher's F), where
    the one holds the noise of shapes that is alike in repeats."""
    return SYSTEMATIC**2 * float(fdtri(degrees, degrees, 1 - LEFT)) if degrees > 0 else np.inf


def largest_factor(deviation: float) -> float:
    """The same of an RMS beside the noise level, whose logarithm is about normal with this deviation."""
    return SYSTEMATIC * float(np.exp(ndtri(1 - LEFT) * deviation))


def structure(left: Floats, following: NDArray[np.bool_]) -> Floats:
    """Mean square (K,) of channels (R, K), NaN unknown, that are in units of their noise; 0 where chance makes as much.

    White noise is not in it: mean products of successive rows are no squares. following (R - 1,): which rows have one
    of the same record before them. All channels that are known twice are tried.
    """
    products = (left[1:] * left[:-1])[following]
    count = np.isfinite(products).sum(axis=0)
    known = count > 1
    found = np.zeros(left.shape[1])
    mean = np.nanmean(products[:, known], axis=0)
    chance = np.nanmean(left[:, known] ** 2, axis=0) / np.sqrt(count[known])
    found[known] = np.where(mean > ndtri(1 - ERROR / max(int(known.sum()), 1)) * chance, mean, 0.0)
    return found
