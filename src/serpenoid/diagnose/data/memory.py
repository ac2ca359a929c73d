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

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import ERROR
from serpenoid.diagnose.data.repeats import Repeat
from serpenoid.diagnose.data.windows import Track

BLOCK = 64  # windows, eight cycles: of a long trial, what is seen at once
FINER = 4.0  # the shortest time that is tried is so much shorter than a window: as good as none
ROUNDING = 1e-9  # of a variance
NEVER = 1e-4  # how likely a time is that is left out
NEIGHBOURS = 1 + 2 * 0.5**2  # where nothing is known: neighbours correlate by -1/2 at most, by their pose


@dataclass(frozen=True)
class Memory:
    """Times in which pushes are forgotten (M,) [s], and how likely each is (M,). No times: windows are independent.

    likelihood: ln of the differences' own, but for a constant, the mean over all times. shared (3,): variance of what
    repeats share over that of chance, by direction.
    """

    times: tuple[float, ...] = ()
    weights: tuple[float, ...] = ()
    likelihood: float = 0.0
    shared: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @classmethod
    def told(
        cls, tracks: Sequence[Track], again: Sequence[Repeat], left: Sequence[Floats], chance: Sequence[Floats]
    ) -> Memory:
        """By differences between repeats of residuals (W, 3) of each track, whose chance is (W, 3) each."""
        shortest = min(float(t.duration[t.playing].min()) for t in tracks if t.playing.any())
        longest = max(float(t.duration.sum()) for t in tracks)
        times = [0.0, *np.geomspace(shortest / FINER, longest, 2 + int(np.log2(FINER * longest / shortest)))]
        logs, own, both = np.zeros(len(times)), np.zeros(3), np.zeros(3)
        for repeat in again:
            track, (one, other) = tracks[repeat.one], repeat.both(left)
            d = (one - other) / np.sqrt(2)
            use = track.playing[repeat.here] & np.isfinite(d).all(axis=1)
            if use.any():
                here = repeat.here[use]
                own += (d[use] ** 2 / chance[repeat.one][here] ** 2).sum(axis=0)
                both += ((one * other)[use] / chance[repeat.one][here] ** 2).sum(axis=0)
                of = partial(covariance, track, chance[repeat.one], np.array(times))
                logs += _likelihood(d[use], roots(of, here))
        weights = np.exp(logs - logs.max())
        likelihood = float(logs.max() + np.log(weights.mean()))
        shared = np.maximum(both, 0.0) / np.where(own > 0, own, 1.0)
        return cls(tuple(times), tuple(weights / weights.sum()), likelihood, tuple(shared.tolist()))

    @property
    def lasts(self) -> bool:
        """Whether repeats exclude that pushes are forgotten at once: the mean likelihood of all times over that of none
        exceeds 1 / ERROR, by chance, with no more than this probability (Markov's inequality)."""
        return bool(self.times) and self.weights[0] * len(self.times) < ERROR

    def covariance(self, track: Track, chance: Floats, windows: np.ndarray) -> Floats:
        """(3, W, W) of some windows of a track, by index, SD (W, 3) each: the mean over what times are likely."""
        likely = [(t, w) for t, w in zip(self.times, self.weights, strict=True) if w > NEVER]
        return np.asarray(sum(w * covariance(track, chance, t, windows) for t, w in likely) / sum(w for _, w in likely))

    def draws(self, track: Track, chance: Floats, rng: np.random.Generator, count: int) -> Floats:
        """Chance of a track's windows (count, W, 3) with SD (W, 3), each time as often as it is likely."""
        white = rng.normal(size=(count, *chance.shape))
        if not self.times:
            return white * chance
        which = np.searchsorted(np.cumsum(self.weights), (np.arange(count) + 0.5) / count * (1 - ROUNDING))
        every = np.arange(len(chance))
        for i in np.unique(which):
            mine = white[which == i].transpose(2, 1, 0)
            for span, inverse in roots(partial(covariance, track, chance, self.times[i]), every):
                rows = inverse.shape[1]
                told = inverse[:, :, :-rows] @ mine[:, span][:, :-rows]
                mine[:, span.stop - BLOCK : span.stop] = np.linalg.solve(
                    inverse[:, :, -rows:], mine[:, span][:, -rows:] - told
                )
            white[which == i] = mine.transpose(2, 1, 0)
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


def covariance(track: Track, chance: Floats, time: float | Floats, windows: np.ndarray | None = None) -> Floats:
    """(3, W, W) of windows (all, or some by index), SD (W, 3) each, if pushes are forgotten in `time` [s]; (M, 3, W, W)
    of several times."""
    own = np.arange(len(chance)) if windows is None else windows
    poses = np.broadcast_to(track.least, chance.shape)[own].T
    pushes = np.sqrt(np.maximum(chance[own].T ** 2 - poses**2, 0.0))
    apart = own[None] - own[:, None]
    shared = (apart == 0) - 0.5 * (np.abs(apart) == 1)
    playing = track.playing[own]
    lasting = np.where(playing[:, None] & playing[None], _lasting(track, own, np.asarray(time)), apart == 0)
    alone = shared * poses[:, :, None] * poses[:, None]
    alone = alone + ROUNDING * np.einsum("ki,ij->kij", chance[own].T ** 2, np.eye(len(own)))
    return np.asarray(alone + lasting[..., None, :, :] * (pushes[:, :, None] * pushes[:, None]))


def _lasting(track: Track, own: np.ndarray, times: Floats) -> Floats:
    """Correlation (..., W, W) of what pushes add up to over windows, for each of some times."""
    ends = track.time[track.boundaries]
    begin, end = ends[own], ends[own + 1]
    rates = 1 / np.where(times > 0, times, 1.0)[..., None]
    faded = -np.expm1(-(end - begin) * rates)
    size = faded / np.sqrt(2 * ((end - begin) * rates - faded))
    gap = np.maximum(begin[None] - end[:, None], 0.0)
    gap = gap + gap.T
    same = np.eye(len(own))
    correlated = size[..., :, None] * size[..., None, :] * np.exp(-gap * rates[..., None])
    return np.where((same > 0) | (times == 0)[..., None, None], same, correlated)


def roots(of: Callable[[np.ndarray], Floats], windows: np.ndarray) -> Iterator[tuple[slice, Floats]]:
    """L^-1 of the covariance L L^T of windows (W,), block by block: which of them tell, and its rows (..., 3, R, told
    by).

    of: covariance (..., 3, K, K) of some windows. A block of a long trial is seen beside the one before it alone
    (Vecchia, J. R. Stat. Soc. B 50, 297, 1988), so cost grows with the number of windows, not with its cube.
    """
    for begin in range(0, max(len(windows), 1), BLOCK):
        span = slice(max(begin - BLOCK, 0), begin + BLOCK)
        yield span, np.linalg.inv(np.linalg.cholesky(of(windows[span])))[..., begin - span.start :, :]


def _likelihood(values: Floats, found: Iterable[tuple[slice, Floats]]) -> Floats:
    """ln of it, but for a constant, of values (W, 3) by the roots of their covariance; of several (M,)."""
    total = np.zeros(())
    for span, inverse in found:
        white = (inverse @ values[span].T[..., None])[..., 0]
        own = np.diagonal(inverse[..., -inverse.shape[-2] :], axis1=-2, axis2=-1)
        total = total + np.log(own).sum(axis=(-2, -1)) - (white**2).sum(axis=(-2, -1)) / 2
    return total
