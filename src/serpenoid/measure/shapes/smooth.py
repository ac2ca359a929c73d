"""A smooth path through noisy states: local cubics, with the window that Mallows' criterion picks.

Only a point to linearise about and a shape to resimulate: the measured states and their covariance stay as they are.
    Cp(K) = sum |z - H_K z|^2 / s^2 + 2 tr(H_K),            K rows in the window
    GCV(K) = R |z - H_K z|^2 / (R - tr H_K)^2,              where the noise s is not known
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from serpenoid.measure.blocks import blocks
from serpenoid.measure.cells import Floats

Smoother = tuple[Floats, NDArray[np.int64]]  # weights (R, K) and rows (R, K)
WINDOWS = (1, 5, 7, 9, 13, 17, 25, 35, 49)
DEGREE = 3
FAR = float(WINDOWS[-1])  # usual steps: beyond such a gap nothing tells of what is on this side of it


def smoother(time_s: Floats, window: int) -> Smoother:
    """Weights (R, K) and rows (R, K): smoothed row r = sum_k weights[r, k] values[rows[r, k]]; across no gap."""
    count = len(time_s)
    steps = np.diff(time_s)
    ends = np.flatnonzero(steps > FAR * np.median(steps)) + 1 if count > 2 else np.zeros(0, int)
    if len(ends):
        return _side_by_side([smoother(piece, window) for piece in np.split(time_s, ends)])
    k = min(window, count)
    first = np.clip(np.arange(count) - k // 2, 0, count - k)
    rows = first[:, None] + np.arange(k)
    if k <= DEGREE:
        return (rows == np.arange(count)[:, None]).astype(float), rows
    weights = np.empty(rows.shape)
    for b in blocks(count):
        u = time_s[rows[b]] - time_s[b, None]
        u = u / np.abs(u).max(axis=1, keepdims=True)
        powers = np.stack([np.ones_like(u), *np.cumprod(np.stack([u] * DEGREE), axis=0)], axis=-1)
        gram = np.swapaxes(powers, 1, 2) @ powers
        weights[b] = (powers @ np.linalg.inv(gram)[:, :, :1])[..., 0]
    return weights, rows


def _side_by_side(pieces: Sequence[Smoother]) -> Smoother:
    """One smoother of successive pieces, each by itself; what a short one lacks in width weighs nothing."""
    count, width = sum(len(rows) for _, rows in pieces), max(rows.shape[1] for _, rows in pieces)
    weights = np.zeros((count, width))
    found = np.repeat((np.arange(count)[:, None] + 1) % count, width, axis=1)  # never the row itself
    first = 0
    for own, rows in pieces:
        here = slice(first, first + len(rows)), slice(rows.shape[1])
        weights[here], found[here] = own, rows + first
        first += len(rows)
    return weights, found


def smooth(values: Floats, weights: Floats, rows: np.ndarray) -> Floats:
    """Apply `smoother` to columns (R, c)."""
    found = np.empty((len(rows), values.shape[1]))
    for b in blocks(len(rows)):
        found[b] = np.einsum("rk,rkc->rc", weights[b], values[rows[b]])
    return found


def best_windows(time_s: Floats, columns: Sequence[tuple[Floats, Floats]]) -> list[int]:
    """For each (values (R, c), noise variances (R, c)) the window with the smallest Cp."""
    return [window for _, window in scored_windows(time_s, columns)]


def scored_windows(time_s: Floats, columns: Sequence[tuple[Floats, Floats]]) -> list[tuple[float, int]]:
    """The smallest Cp of each, and its window."""
    scores: list[list[tuple[float, int]]] = [[] for _ in columns]
    for window in WINDOWS:
        if window > len(time_s):
            break
        weights, rows = smoother(time_s, window)
        own = own_weights((weights, rows)).sum()
        for scored, (values, variance) in zip(scores, columns, strict=True):
            misfit = ((values - smooth(values, weights, rows)) ** 2 / variance).sum()
            scored.append((misfit + 2 * own * values.shape[1], window))
    return [min(scored) for scored in scores]


def best_window(time_s: Floats, values: Floats, variance: Floats) -> int:
    """The window with the smallest Cp for columns (R, c) with noise variances (R, c)."""
    return best_windows(time_s, ((values, variance),))[0]


def angles_smoother(time_s: Floats, joint_angles: Floats, covariance: Floats) -> Callable[[Floats], Floats]:
    """What smooths joint angles (R, m) like these of noise (R, m, m): one window for all."""
    variance = np.maximum(np.diagonal(covariance, axis1=1, axis2=2), 1e-24)
    weights, rows = smoother(time_s, best_window(time_s, joint_angles, variance))
    return lambda angles: smooth(angles, weights, rows)


def smooth_states(time_s: Floats, poses: Floats, joint_angles: Floats, covariance: Floats) -> tuple[Floats, Floats]:
    """Smoothed poses (R, 3) and joint angles (R, m); each with its own window."""
    variance = np.maximum(np.diagonal(covariance, axis1=1, axis2=2), 1e-24)
    windows = best_windows(time_s, ((poses, variance[:, :3]), (joint_angles, variance[:, 3:])))
    of_poses, of_angles = (smoother(time_s, window) for window in windows)
    return smooth(poses, *of_poses), smooth(joint_angles, *of_angles)


def smoothers(time_s: Floats) -> tuple[Smoother, ...]:
    """Of every window that smooths and that so many rows fill."""
    return tuple(smoother(time_s, window) for window in WINDOWS if DEGREE < window <= len(time_s))


def own_weights(by: Smoother) -> Floats:
    """Weight (R,) of every row in its own smoothed value."""
    weights, rows = by
    return weights[rows == np.arange(len(rows))[:, None]]


def cross_validated(time_s: Floats, values: Floats, scale: Floats | float = 1.0) -> Smoother | None:
    """The `smoother` of columns (R, c) of unknown noise; scale (c,): what counts as much. None: too few rows."""
    best = None
    for by in smoothers(time_s):
        left = (values - smooth(values, *by)) * scale
        freedom = len(time_s) - own_weights(by).sum()
        if not freedom > 0:  # all in pieces too short to smooth
            continue
        score = (left**2).sum() / freedom**2
        if best is None or score < best[0]:
            best = score, by
    return None if best is None else best[1]
