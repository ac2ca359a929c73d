"""What repeats share of the residuals: noise of shapes, a little of which is alike in repeats, or else a discrepancy.

With m the mean and d the difference of two repeats' residuals, the ratio 4 sum m^2 / sum d^2 is 1 if only chance is
left. What the baseline is in doubt about repeats, too, and is no news.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.data.noise import residuals
from serpenoid.diagnose.data.repeats import repeats
from serpenoid.diagnose.data.windows import Prediction

RATIO = 2.0  # repeatable over unrepeatable: on nothing 1 +- 0.2, and noise of shapes repeats a little


def repeatable(motion: Motion, left: Sequence[Floats]) -> tuple[float, Floats]:
    """Ratio over all windows and components, and by component (3,).

    Where tracks bring their own noise nothing is repeated: mean squares in units of that noise.
    """
    own = [x / motion.noise.of(t) for t, x in zip(motion.tracks, left, strict=True) if t.noise is not None]
    if own:
        by = np.nanmean(np.concatenate(own) ** 2, axis=0)
        return float(by.mean()), by
    top, bottom = np.zeros(3), np.zeros(3)
    for repeat in repeats(motion.tracks):
        track, (one, other) = motion.tracks[repeat.one], repeat.both(left)
        noise = motion.noise.of(track)[repeat.here]
        doubt = np.broadcast_to(track.doubt, track.displacement.shape)[repeat.here] / noise
        m, d = (one + other) / noise, (one - other) / noise
        top += np.nansum(m**2, axis=0)
        bottom += np.nansum(d**2 + np.where(np.isfinite(d), 2 * doubt, 0.0) ** 2, axis=0)
    if not bottom.any():
        return 1.0, np.ones(3)
    return float(top.sum() / bottom.sum()), np.divide(top, bottom, out=np.ones(3), where=bottom > 0)


def discrepancy(motion: Motion, predictions: Sequence[Prediction]) -> float:
    """RMS [m] of what repeats share of a window's displacement; 0 where that is no more than chance and doubt.

    m and d as above: E m^2 = D^2 + s^2 / 2, E d^2 = 2 s^2.
    """
    left = residuals(motion.tracks, predictions)
    if repeatable(motion, left)[0] <= RATIO:
        return 0.0
    squares = [x**2 - motion.noise.of(t) ** 2 for t, x in zip(motion.tracks, left, strict=True) if t.noise is not None]
    for repeat in [] if squares else repeats(motion.tracks):
        one, other = repeat.both(left)
        squares.append(one * other)  # m^2 - d^2 / 4
    return float(np.sqrt(max(0.0, float(np.nanmean(np.concatenate(squares), axis=0)[:2].sum()))))
