"""How long chance lasts: covariance of a window's chance with that of the other windows of its trial.

A window holds the noise of the poses at its ends, which its neighbours share with the other sign, and pushes. Of their
variance a share s is of a law that is another in this trial (a floor that grips more, a wheel that runs harder): it
comes again in every cycle, at the same phase. The rest is forgotten in time tau: of what such pushes add up to over
windows i before j, a gap apart,

    cov(i, j) ~ a_i a_j exp(-gap / tau),   var(i) ~ 2 (w_i / tau - a_i),   a_i = 1 - exp(-w_i / tau)

(the integrated Ornstein-Uhlenbeck process). How large chance is, repeats tell (noise.py), and how large the markers'
part of it; tau and s, too: each pair of a range has the likelihood of the repeats' differences. None is chosen: draws
are made with each as often as it is likely, so that what repeats leave open about it is in the draws. Cycles of one
trial share what comes again: where only cycles were repeated s is not known, and taken for 0.

What comes again does so in a pattern of its own, which nobody knows: of all windows of a cycle it may be a few numbers
only. How many, sums of squares of pairs of trials tell: they scatter the more, the fewer they are.

Legend: W windows of a track, M pairs of a time and a share.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from scipy.special import betaln

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import ERROR
from serpenoid.diagnose.data.noise.repeats import Repeat
from serpenoid.diagnose.data.windows.windows import Track

BLOCK = 64  # windows, eight cycles: of a long trial, what is seen at once
FINER = 4.0  # the shortest time that is tried is so much shorter than a window: as good as none
ROUNDING = 1e-9  # of a variance
NEVER = 1e-4  # how likely a time is that is left out
RECURRING = (0.0, 0.3, 0.6, 0.9)  # that are tried
SHARES = 101  # of poses that are tried, evenly from none to all
NEIGHBOURS = 1 + 2 * 0.5**2  # where nothing is known: neighbours correlate by -1/2 at most, by their pose


@dataclass(frozen=True)
class Memory:
    """Times in which pushes are forgotten (M,) [s], shares of them that come again in every cycle (M,), and how likely
    each pair is (M,). No times: windows are independent.

    likelihood: ln of the differences' own, but for a constant, the mean over all pairs. shared (3,): variance of what
    repeats share over that of chance, by direction. scattered: ln likelihood of each factor of two (1, 2, ..) by which
    a trial's windows are worth fewer numbers than their covariance says. bound: windows are never taken for
    independent, for it is known how large the part of poses is.
    """

    times: tuple[float, ...] = ()
    weights: tuple[float, ...] = ()
    recurring: tuple[float, ...] = ()
    likelihood: float = 0.0
    shared: tuple[float, float, float] = (0.0, 0.0, 0.0)
    scattered: tuple[float, ...] = ()
    bound: bool = False

    @classmethod
    def of_poses(cls) -> Memory:
        """Of windows whose neighbours share the noise of the poses between them, and nothing else."""
        return cls((0.0,), (1.0,), (0.0,), bound=True)

    @classmethod
    def told(
        cls, tracks: Sequence[Track], again: Sequence[Repeat], left: Sequence[Floats], chance: Sequence[Floats]
    ) -> Memory:
        """By differences between repeats of residuals (W, 3) of each track, whose chance is (W, 3) each."""
        shortest = min(float(t.duration[t.playing].min()) for t in tracks if t.playing.any())
        longest = max(float(t.duration.sum()) for t in tracks)
        lasting = [0.0, *np.geomspace(shortest / FINER, longest, 2 + int(np.log2(FINER * longest / shortest)))]
        in_trials = all(r.one != r.other for r in again)
        times, recurring = np.array([(t, s) for s in (RECURRING if in_trials else RECURRING[:1]) for t in lasting]).T
        logs, own, both = np.zeros(len(times)), np.zeros(3), np.zeros(3)
        squares, counts = [], []
        for repeat in again:
            track, (one, other) = tracks[repeat.one], repeat.both(left)
            d = (one - other) / np.sqrt(2)
            use = track.playing[repeat.here] & np.isfinite(d).all(axis=1)
            if use.any():
                here = repeat.here[use]
                size = chance[repeat.one][here]
                squares.append([((x[use] / size) ** 2).sum(axis=0) for x in (one + other, d)])
                counts.append((repeat.one, len(here)))
                own += squares[-1][1]
                both += ((one * other)[use] / size**2).sum(axis=0)
                of = partial(covariance, track, chance[repeat.one], times, recurring)
                logs += _likelihood(d[use], roots(of, here))
        weights = np.exp(logs - logs.max())
        likelihood = float(logs.max() + np.log(weights.mean()))
        shared = np.maximum(both, 0.0) / np.where(own > 0, own, 1.0)
        likely = tuple((weights / weights.sum()).tolist())
        found = cls(tuple(times.tolist()), likely, tuple(recurring.tolist()), likelihood, tuple(shared.tolist()))
        if not in_trials or not squares:
            return found
        worth = [count / found.common(tracks[i], chance[i]) for i, count in counts]
        return replace(found, scattered=_scattered(np.concatenate(squares, axis=1), np.repeat(worth, 3)))

    def beside(self, scattered: Sequence[float]) -> Memory:
        """By what repeats of an earlier campaign tell of the same, too."""
        count = min(len(self.scattered), len(scattered)) if self.scattered else len(scattered)
        both = [sum(x) for x in zip(self.scattered or (0.0,) * count, scattered[:count], strict=False)]
        return replace(self, scattered=tuple(both)) if both else self

    @cached_property
    def fewer(self) -> float:
        """How many times fewer: the mean, each factor as often as it is likely; 1 where that is not excluded."""
        if not self.scattered:
            return 1.0
        likely = np.exp(np.array(self.scattered) - max(self.scattered))
        likely = likely / likely.sum()
        return float(likely @ 2.0 ** np.arange(len(likely))) if likely[0] * len(likely) < ERROR else 1.0

    @property
    def lasts(self) -> bool:
        """Whether repeats exclude that pushes are forgotten at once: the mean likelihood of all pairs over that of none
        exceeds 1 / ERROR, by chance, with no more than this probability (Markov's inequality)."""
        return bool(self.times) and self.weights[0] * len(self.times) < ERROR

    @property
    def correlates(self) -> bool:
        """Whether windows are seen beside those before them."""
        return self.bound or self.lasts

    def covariance(self, track: Track, chance: Floats, windows: np.ndarray) -> Floats:
        """(3, W, W) of some windows of a track, by index, SD (W, 3) each: the mean over what pairs are likely."""
        likely = self._likely
        total = sum(w * covariance(track, chance, t, s, windows) for t, s, w in likely)
        return np.asarray(total / sum(w for *_, w in likely))

    @property
    def _likely(self) -> list[tuple[float, float, float]]:
        """(time, share, how likely) of pairs that may be."""
        pairs = zip(self.times, self.recurring, self.weights, strict=True)
        return [(t, s, w) for t, s, w in pairs if w > NEVER]

    def draws(self, track: Track, chance: Floats, rng: np.random.Generator, count: int) -> Floats:
        """Chance of a track's windows (count, W, 3) with SD (W, 3), each pair as often as it is likely."""
        white = rng.normal(size=(count, *chance.shape))
        if not self.times:
            return white * chance
        which = np.searchsorted(np.cumsum(self.weights), (np.arange(count) + 0.5) / count * (1 - ROUNDING))
        every = np.arange(len(chance))
        for i in np.unique(which):
            mine = white[which == i].transpose(2, 1, 0)
            for span, inverse in roots(partial(covariance, track, chance, self.times[i], self.recurring[i]), every):
                rows = inverse.shape[1]
                told = inverse[:, :, :-rows] @ mine[:, span][:, :-rows]
                mine[:, span.stop - BLOCK : span.stop] = np.linalg.solve(
                    inverse[:, :, -rows:], mine[:, span][:, -rows:] - told
                )
            white[which == i] = mine.transpose(2, 1, 0)
        return white

    def common(self, track: Track, chance: Floats) -> float:
        """Variance of a sum of squares of a track's windows in units of their chance (W, 3), over that of as many
        independent ones: 1 and the squares of each window's correlations, of all pairs as likely as they are."""
        if not self.times:
            return NEIGHBOURS
        squares = 0.0
        for time, share, weight in self._likely:
            found = covariance(track, chance, time, share) / (chance.T[:, :, None] * chance.T[:, None])
            squares += weight * float((found**2).sum())
        return squares / chance.size * self.fewer


def covariance(
    track: Track, chance: Floats, time: float | Floats, share: float | Floats = 0.0, windows: np.ndarray | None = None
) -> Floats:
    """(3, W, W) of windows (all, or some by index), SD (W, 3) each, if `share` of the pushes comes again in every cycle
    and the rest is forgotten in `time` [s]; (M, 3, W, W) of several of each."""
    own = np.arange(len(chance)) if windows is None else windows
    poses = np.broadcast_to(track.least, chance.shape)[own].T
    pushes = np.sqrt(np.maximum(chance[own].T ** 2 - poses**2, 0.0))
    apart = own[None] - own[:, None]
    shared = (apart == 0) - 0.5 * (np.abs(apart) == 1)
    playing = track.playing[own]
    again, recurring = track.phase[own][:, None] == track.phase[own][None], np.asarray(share)[..., None, None]
    pushed = (1 - recurring) * _lasting(track, own, np.asarray(time)) + recurring * again
    lasting = np.where(playing[:, None] & playing[None], pushed, apart == 0)
    alone = shared * poses[:, :, None] * poses[:, None]
    alone = alone + ROUNDING * np.einsum("ki,ij->kij", chance[own].T ** 2, np.eye(len(own)))
    return np.asarray(alone + lasting[..., None, :, :] * (pushes[:, :, None] * pushes[:, None]))


def share_of_poses(draws: Sequence[Floats]) -> Floats:
    """Of the variance of a window (3,), the likeliest by draws (.., W, 3) of parts of a recording in units of their
    noise."""
    tried = np.linspace(0.0, 1.0, SHARES)
    logs = np.zeros((SHARES, 3))
    for z in (z for z in draws if np.isfinite(z).all()):
        count = z.shape[-2]
        angles = np.pi * np.arange(1, count + 1) / (count + 1)
        waves = np.sqrt(2 / (count + 1)) * np.sin(np.outer(np.arange(1, count + 1), angles))
        squares = ((waves @ z) ** 2).reshape(-1, count, 3)
        variances = 1 - np.outer(tried, np.cos(angles))
        logs -= (len(squares) * np.log(variances).sum(axis=1)[:, None] + (1 / variances) @ squares.sum(axis=0)) / 2
    return np.asarray(tried[logs.argmax(axis=0)])


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


def _scattered(squares: Floats, degrees: Floats) -> tuple[float, ...]:
    """ln likelihood of each factor of two by which the sum and the difference of two repeats have fewer degrees of
    freedom than by their covariance (K,).

    squares (2, K): of the sum and of the difference. Where chance alone is in both, their ratio is Fisher's F; what
    repeats share makes all ratios larger, and their mean logarithm is not looked at.
    """
    factors = 2.0 ** np.arange(1 + int(np.log2(max(float(degrees.max()), 1.0))))
    told = (squares > 0).all(axis=0)  # of a campaign beside itself the sum of two repeats is 0
    if not told.any():
        return (0.0,) * len(factors)
    shape = degrees[told] / factors[:, None] / 2
    z = np.log(squares[0, told] / squares[1, told])
    z = z - z.mean()
    return tuple((shape * z - 2 * shape * np.logaddexp(0.0, z) - betaln(shape, shape)).sum(axis=1).tolist())


def _likelihood(values: Floats, found: Iterable[tuple[slice, Floats]]) -> Floats:
    """ln of it, but for a constant, of values (W, 3) by the roots of their covariance; of several (M,)."""
    total = np.zeros(())
    for span, inverse in found:
        white = (inverse @ values[span].T[..., None])[..., 0]
        own = np.diagonal(inverse[..., -inverse.shape[-2] :], axis1=-2, axis2=-1)
        total = total + np.log(own).sum(axis=(-2, -1)) - (white**2).sum(axis=(-2, -1)) / 2
    return total
