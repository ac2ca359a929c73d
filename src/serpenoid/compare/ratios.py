"""Performance ratios as in the paper, and what their mean and standard deviation hide.

delta_X(i, j) = Delta_X(i) / Delta_X(j);  Xi_XY = delta_X / delta_Y = q_i / q_j,  q = Delta_X / Delta_Y
(Even et al. 2024, Sec. V)

Since Xi_ij Xi_ji = 1, the mean of Xi is at least 1 whatever the data, and a scale common to all of X cancels. For
log-normal q with SD s of ln q: mean = exp(s^2) (off the diagonal), var = exp(4 s^2) - exp(2 s^2).

Legend: G gaits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError

RESAMPLES = 2000


@dataclass(frozen=True)
class RatioStatistics:
    """Of one pair of classes; `quotients` is Xi (G, G)."""

    pair: str
    quotients: Floats
    mean: float  # of Xi without the diagonal, as published
    std: float
    bias: float  # exp(mean of ln q): 1 where Y predicts the size of X rightly
    bias_interval: tuple[float, float]
    s: float  # SD of ln q
    s_interval: tuple[float, float]
    rank_correlation: float  # Spearman; nan for fewer than 3 different gaits
    wrong_pairs: tuple[tuple[int, int], ...]  # i does better than j in X and worse in Y

    @property
    def rank_text(self) -> str:
        """A dash where there are too few different gaits to rank."""
        return f"{self.rank_correlation:.3f}" if np.isfinite(self.rank_correlation) else "-"

    @property
    def pair_count(self) -> int:
        gaits = len(self.quotients)
        return gaits * (gaits - 1) // 2


def performance_ratios(displacement: Floats) -> Floats:
    """delta (G, G) of net displacements (G,)."""
    return displacement[:, None] / displacement[None, :]


def ratio_statistics(pair: str, x: Floats, y: Floats, seed: int = 0) -> RatioStatistics:
    """Compare displacements x and y (G,) of the same gaits. At least two gaits, all displacements positive."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    if x.shape != y.shape or len(x) < 2:
        raise InputError(f"{pair}: performance ratios need the same two or more gaits in both classes, got {len(x)}.")
    if not ((x > 0) & (y > 0)).all():
        raise InputError(
            f"{pair}: displacements must be positive. A gait that does not move has no ratio: leave it out."
        )
    from scipy.stats import spearmanr  # as long to import as all the rest, and `measure` needs it not

    quotients = performance_ratios(x) / performance_ratios(y)
    off = quotients[~np.eye(len(x), dtype=bool)]
    log_q = np.log(x / y)
    bias_interval, s_interval = _bootstrap(log_q, seed)
    varied = len(x) > 2 and np.ptp(x) > 0 and np.ptp(y) > 0
    rank = float(spearmanr(x, y).statistic) if varied else float("nan")
    return RatioStatistics(
        pair, quotients, float(off.mean()), float(off.std(ddof=1)) if len(off) > 1 else 0.0,
        float(np.exp(log_q.mean())), bias_interval, float(log_q.std(ddof=1)), s_interval, rank, wrong_pairs(x, y),
    )  # fmt: skip


def wrong_pairs(x: Floats, y: Floats) -> tuple[tuple[int, int], ...]:
    """Pairs (better in x, worse in x) that y orders the other way round."""
    better = x[:, None] > x[None, :]
    return tuple((int(i), int(j)) for i, j in np.argwhere(better & (y[:, None] < y[None, :])))


def _bootstrap(log_q: Floats, seed: int) -> tuple[tuple[float, float], tuple[float, float]]:
    """95 % intervals of bias and s over resampled gaits (gaits, not pairs, are independent).

    A resample of G gaits has its variance shrunk by (G - 1)/G; s is put right for it.
    """
    rng = np.random.default_rng(seed)
    gaits = len(log_q)
    drawn = log_q[rng.integers(0, gaits, size=(RESAMPLES, gaits))]
    s = drawn.std(axis=1, ddof=1) * np.sqrt(gaits / (gaits - 1))
    bias = np.exp(drawn.mean(axis=1))
    low, high = np.percentile(bias, [2.5, 97.5]), np.percentile(s, [2.5, 97.5])
    return (float(low[0]), float(low[1])), (float(high[0]), float(high[1]))
