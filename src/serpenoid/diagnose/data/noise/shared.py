"""What repeats share of the residuals: chance, or else a discrepancy.

With m the mean and d the difference of two repeats' residuals, the ratio 4 sum m^2 / sum d^2 is 1 if only chance is
left, and exceeds a quantile of Fisher's F with a stated probability. How many numbers the residuals are worth, the
fourth moment of d tells: directions, settings and pauses differ in noise. They are worth the fewer, the longer chance
lasts (memory.py). What the baseline is in doubt about repeats, too, and is no news.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import GAUSSIAN, largest_ratio
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.noise import residuals
from serpenoid.diagnose.data.noise.repeats import repeats
from serpenoid.diagnose.data.noise.untold import untold
from serpenoid.diagnose.data.shapes.geometry import way
from serpenoid.diagnose.data.windows.windows import Prediction


@dataclass(frozen=True)
class Shared:
    """Ratio over all windows and components, and by component (3,); chance: the largest ratio that chance makes."""

    ratio: float = 1.0
    by: Floats = field(default_factory=lambda: np.ones(3))
    chance: float = np.inf

    @property
    def news(self) -> bool:
        """Whether more is shared than chance makes."""
        return self.ratio > self.chance


def repeatable(motion: Motion, left: Sequence[Floats]) -> Shared:
    """What repeats share of residuals (W, 3) of each track.

    Where tracks bring their own noise nothing is repeated: mean squares in units of that noise.
    """
    own = [x / motion.noise.of(t) for t, x in zip(motion.tracks, left, strict=True) if t.noise is not None]
    return _beyond(own) if own else _shared(motion, left)


def _beyond(white: Sequence[Floats]) -> Shared:
    """Of residuals (W, 3) of each track in units of their noise."""
    squares = np.concatenate(white) ** 2
    count = int(np.isfinite(squares).sum())
    return Shared(float(np.nanmean(squares)), np.nanmean(squares, axis=0), largest_ratio(count))


def _shared(motion: Motion, left: Sequence[Floats]) -> Shared:
    top, bottom, fourth, common, count = np.zeros(3), np.zeros(3), 0.0, 0.0, 0
    for repeat in repeats(motion.tracks):
        track, (one, other) = motion.tracks[repeat.one], repeat.both(left)
        noise = motion.noise.of(track)[repeat.here]
        doubt = np.broadcast_to(track.doubt, track.displacement.shape)[repeat.here] / noise
        m, d = (one + other) / noise, (one - other) / noise
        known = np.isfinite(d)
        top += np.nansum(m**2, axis=0)
        bottom += np.nansum(d**2 + np.where(known, 2 * doubt, 0.0) ** 2, axis=0)
        fourth += float(np.nansum(d**4))
        common += known.sum() * motion.noise.memory.common(track, motion.noise.chance(track))
        count += int(known.sum())
    if not bottom.any():
        return Shared()
    ratio, by = top.sum() / bottom.sum(), np.divide(top, bottom, out=np.ones(3), where=bottom > 0)
    degrees = GAUSSIAN * float(bottom.sum()) ** 2 / fourth * count / common if fourth > 0 else 0.0
    return Shared(float(ratio), by, largest_ratio(degrees))


def discrepancy(motion: Motion, predictions: Sequence[Prediction]) -> float:
    """RMS [m] of what repeats share of a window's displacement, and of what trials that were not laid alike differ by
    (untold.py); 0 where that is no more than chance and doubt.

    m and d as above: E m^2 = D^2 + s^2 / 2, E d^2 = 2 s^2, so D^2 is the mean of m^2 - d^2 / 4 in each direction; and
    no less than the mean in which a window counts by 1 / s^2, as it does in the ratio: what is news has a size. A turn
    counts as the way of the body's points.
    """
    left = residuals(motion.tracks, predictions)
    room = untold(motion, left)
    apart = 0.0 if room is None else room.size
    if not repeatable(motion, left).news:
        return apart
    parts = [
        (x**2 - motion.noise.of(t) ** 2, motion.noise.of(t))
        for t, x in zip(motion.tracks, left, strict=True)
        if t.noise is not None
    ]
    for repeat in [] if parts else repeats(motion.tracks):
        one, other = repeat.both(left)
        parts.append((one * other, motion.noise.of(motion.tracks[repeat.one])[repeat.here]))  # m^2 - d^2 / 4
    squares, noise = (np.concatenate(x) for x in zip(*parts, strict=True))
    certain = np.where(np.isfinite(squares), noise**-2.0, 0.0)
    weighed = (certain * np.nan_to_num(squares)).sum(axis=0) / certain.sum(axis=0)
    missed = np.maximum(np.maximum(np.nanmean(squares, axis=0), weighed), 0.0)
    return float(np.hypot(way(motion.tracks[0].recording.body, missed), apart))
