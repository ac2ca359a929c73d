"""How far markers lie from each other, and how well that is a chain of rigid links.

    log evidence = - E log( rms of (distance - what the body allows) )    lengths given: links are rigid
                   - E log( rms of (distance - its mean) ) - E log( sum of mean distances )       not given
                   - 2 (N - 2) log( rms of the turning angles )           a body does not fold back on itself

rms over edges and frames, each with the tolerance of a marker put on by hand added. Counted once per edge and angle,
however many frames: errors of placing repeat in every frame.

What a distance varies by within what the body allows (`reach`) is no error: of mean m within (low, high) a variance of
(high - m) (m - low) at most (Bhatia and Davis, American Mathematical Monthly 107, 353, 2000).

Legend: F frames, N markers, tail first, E = N - 1 pairs of successive ones, here called edges.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from serpenoid.measure.cells import Floats
from serpenoid.measure.consistency.reach import Reach

MOST_FRAMES = 120  # evenly chosen: posture, not noise, decides
PLACED = 0.05  # of the median edge: a marker put on by hand


@dataclass(frozen=True)
class Layout:
    """Distances between all pairs in F frames (F, N, N), the positions (F, N, 2), and what the body allows, or None."""

    points: Floats
    distance: Floats
    reach: Reach | None

    @cached_property
    def moments(self) -> tuple[np.ndarray, Floats, Floats]:
        """Of each pair (N, N): in how many frames it is seen, the mean of its distances and the sum of squares about
        it. All that links are judged by, in whatever order."""
        known = np.isfinite(self.distance)
        often = known.sum(axis=0)
        mean = np.where(known, self.distance, 0.0).sum(axis=0) / np.maximum(often, 1)
        return often, mean, (np.where(known, self.distance - mean, 0.0) ** 2).sum(axis=0)

    @property
    def neighbours(self) -> Floats:
        """Distances (F, N - 1) along the body."""
        return np.diagonal(self.distance, 1, axis1=1, axis2=2)


def middles(values: Floats) -> Floats:
    """Medians of columns; NaN of those without a number."""
    middle, ever = np.full(values.shape[1], np.nan), np.isfinite(values).any(axis=0)
    middle[ever] = np.nanmedian(values[:, ever], axis=0)
    return middle


def layout(points: Floats, reach: Reach | None) -> Layout:
    """Of markers (F, N, 2) in the unit of `reach`."""
    seen = np.isfinite(points[..., 0]).sum(axis=1) >= min(3, points.shape[1])
    usable = np.flatnonzero(seen)
    some = usable[np.linspace(0, len(usable) - 1, min(len(usable), MOST_FRAMES)).astype(int)] if len(usable) else usable
    chosen = points[some]
    return Layout(chosen, np.linalg.norm(chosen[:, :, None] - chosen[:, None], axis=3), reach)


def evidence(plan: Layout, order: Sequence[int], scale: float = 1.0, reach: Reach | None = None) -> float:
    """Log evidence of markers taken in `order`, their distances multiplied by `scale`."""
    chain = np.asarray(order)
    allowed = plan.reach if reach is None else reach
    often, mean, scatter = (x[chain[:-1], chain[1:]] for x in plan.moments)
    seen = often > 0
    if not seen.any():
        return -np.inf
    often, mean, scatter, count = often[seen], scale * mean[seen], scale**2 * scatter[seen], int(seen.sum())
    typical = np.median(mean) if allowed is None else float(np.median(allowed.high))
    square = _missed(often, mean, scatter, None if allowed is None else (allowed.low[seen], allowed.high[seen])).sum()
    square = square / often.sum()
    miss = float(np.sqrt(square + (PLACED * typical) ** 2))
    if allowed is not None:
        return float(-count * np.log(miss))
    order_of_body = -count * np.log(mean.sum()) - 2 * (len(chain) - 2) * np.log(_folding(plan, chain))
    return float(-count * np.log(miss) + order_of_body)


def _missed(often: np.ndarray, mean: Floats, scatter: Floats, bounds: tuple[Floats, Floats] | None) -> Floats:
    """Sums of squares (E,) by which distances miss what the body allows, or their means."""
    if bounds is None:
        return scatter
    low, high = bounds
    about = np.clip(mean, low, high)
    within = np.maximum(scatter - often * (high - about) * (about - low), 0.0)
    return np.asarray(within + often * (mean - about) ** 2)


def beside(plan: Layout) -> list[int]:
    """Markers whose distances to their neighbours miss by more than those of markers put on by hand."""
    often, mean, scatter = (np.diagonal(x, 1) for x in plan.moments)
    bounds = None if plan.reach is None else (plan.reach.low, plan.reach.high)
    typical = np.median(mean[often > 0]) if plan.reach is None else np.median(plan.reach.high)
    far = np.flatnonzero(_missed(often, mean, scatter, bounds) > often * (PLACED * typical) ** 2)
    return sorted({*far.tolist(), *(far + 1).tolist()})


def flatness(plan: Layout) -> float:
    """Log evidence that these are all of a body's lengths and not a view of it from the side."""
    chain = np.arange(plan.points.shape[1])
    if plan.reach is not None:
        return evidence(plan, chain.tolist())
    distance = plan.neighbours
    distance = distance[:, np.isfinite(distance).any(axis=0)]
    mean = np.nanmean(distance, axis=0)
    miss = np.sqrt(np.nanmean((distance - mean) ** 2) / mean.mean() ** 2 + PLACED**2)
    return float(-len(mean) * np.log(miss))


def _folding(plan: Layout, chain: np.ndarray) -> float:
    """RMS turning angle between successive edges, with the tolerance of placing."""
    edge = np.diff(plan.points[:, chain], axis=1)
    a, b = edge[:, :-1], edge[:, 1:]
    cross, dot = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0], (a * b).sum(axis=2)
    turning = np.arctan2(cross, dot)
    if not np.isfinite(turning).any():
        return 1.0
    return float(np.sqrt(np.nanmean(turning**2) + (2 * PLACED) ** 2))
