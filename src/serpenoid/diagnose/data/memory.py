"""How long chance lasts: covariance of a window's chance with that of the other windows of its trial.

A window holds the noise of the poses at its ends, which its neighbours share with the other sign, and pushes that are
forgotten in time tau: of what pushes add up to over windows i before j, a gap apart,

    cov(i, j) ~ a_i a_j exp(-gap / tau),   var(i) ~ 2 (w_i / tau - a_i),   a_i = 1 - exp(-w_i / tau)

(the integrated Ornstein-Uhlenbeck process). How large chance is, repeats tell (noise.py), and how large the markers'
part of it; tau, too: each of a range of times has the likelihood of the repeats' differences. None is chosen: draws are
made with each as often as it is likely, so that what repeats leave open about tau is in the draws.

Legend: W windows of a track, M times.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.repeats import Repeat
from serpenoid.diagnose.data.windows import Track

FINER = 4.0  # the shortest time that is tried is so much shorter than a window: as good as none
ROUNDING = 1e-9  # of a variance
NEVER = 1e-4  # how likely a time is that is left out
NEIGHBOURS = 1 + 2 * 0.5**2  # where nothing is known: neighbours correlate by -1/2 at most, by their pose


@dataclass(frozen=True)
class Memory:
    """Times in which pushes are forgotten (M,) [s], and how likely each is (M,). No times: windows are independent."""

    times: tuple[float, ...] = ()
    weights: tuple[float, ...] = ()

    @classmethod
    def told(
        cls, tracks: Sequence[Track], again: Sequence[Repeat], left: Sequence[Floats], chance: Sequence[Floats]
    ) -> Memory:
        """By differences between repeats of residuals (W, 3) of each track, whose chance is (W, 3) each."""
        shortest = min(float(t.duration[t.playing].min()) for t in tracks if t.playing.any())
        longest = max(float(t.duration.sum()) for t in tracks)
        times = [0.0, *np.geomspace(shortest / FINER, longest, 2 + int(np.log2(FINER * longest / shortest)))]
        logs = np.zeros(len(times))
        for repeat in again:
            track, (one, other) = tracks[repeat.one], repeat.both(left)
            d = (one - other) / np.sqrt(2)
            use = track.playing[repeat.here] & np.isfinite(d).all(axis=1)
            if use.any():
                here = repeat.here[use]
                logs += [_likelihood(d[use], covariance(track, chance[repeat.one], time, here)) for time in times]
        weights = np.exp(logs - logs.max())
        return cls(tuple(times), tuple(weights / weights.sum()))

    def draws(self, track: Track, chance: Floats, rng: np.random.Generator, count: int) -> Floats:
        """Chance of a track's windows (count, W, 3) with SD (W, 3), each time as often as it is likely."""
        white = rng.normal(size=(count, *chance.shape))
        if not self.times:
            return white * chance
        which = np.searchsorted(np.cumsum(self.weights), (np.arange(count) + 0.5) / count * (1 - ROUNDING))
        for i in np.unique(which):
            root = np.linalg.cholesky(covariance(track, chance, self.times[i]))
            white[which == i] = np.einsum("kij,njk->nik", root, white[which == i])
        return white

    def common(self, track: Track, chance: Floats) -> float:
        """Variance of a sum of squares of a track's windows in units of their chance (W, 3), over that of as many
        independent ones: 1 and the squares of each window's correlations, of all times as likely as they are."""
        if not self.times:
            return NEIGHBOURS
        squares = 0.0
        for time, weight in zip(self.times, self.weights, strict=True):
            if weight > NEVER:
                found = covariance(track, chance, time) / (chance.T[:, :, None] * chance.T[:, None])
                squares += weight * float((found**2).sum())
        return squares / chance.size


def covariance(track: Track, chance: Floats, time: float, windows: np.ndarray | None = None) -> Floats:
    """(3, W, W) of windows (all, or some by index), SD (W, 3) each, if pushes are forgotten in `time` [s]."""
    own = np.arange(len(chance)) if windows is None else windows
    poses = np.broadcast_to(track.least, chance.shape)[own].T
    pushes = np.sqrt(np.maximum(chance[own].T ** 2 - poses**2, 0.0))
    apart = own[None] - own[:, None]
    shared = (apart == 0) - 0.5 * (np.abs(apart) == 1)
    playing = track.playing[own]
    lasting = np.where(playing[:, None] & playing[None], _lasting(track, own, time), apart == 0)
    found = shared * poses[:, :, None] * poses[:, None] + lasting * pushes[:, :, None] * pushes[:, None]
    return found + ROUNDING * np.einsum("ki,ij->kij", chance[own].T ** 2, np.eye(len(own)))


def _lasting(track: Track, own: np.ndarray, time: float) -> Floats:
    """Correlation (W, W) of what pushes add up to over windows."""
    if time == 0.0:
        return np.eye(len(own))
    ends = track.time[track.boundaries]
    begin, end = ends[own], ends[own + 1]
    faded = -np.expm1(-(end - begin) / time)
    size = faded / np.sqrt(2 * ((end - begin) / time - faded))
    gap = np.maximum(begin[None] - end[:, None], 0.0)
    gap = gap + gap.T
    return np.where(np.eye(len(own), dtype=bool), 1.0, size[:, None] * size * np.exp(-gap / time))


def _likelihood(values: Floats, of: Floats) -> float:
    """ln of it, but for a constant, of values (W, 3) with covariance (3, W, W)."""
    root = np.linalg.cholesky(of)
    white = np.linalg.solve(root, values.T[..., None])
    return float(-np.log(np.einsum("kii->ki", root)).sum() - (white**2).sum() / 2)
