"""Clocks without a common zero: the offset that lays one signal best over another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from serpenoid.measure.cells import Floats

GRID_S = 0.04  # search grid: far finer than a gait cycle; the best shift is refined afterwards


@dataclass(frozen=True)
class Offset:
    """Reference clock = other clock + offset_s. `correlation` of the signals there, `rms` of their difference."""

    offset_s: float
    correlation: float
    rms: float


def interpolate(time_s: Floats, values: Floats, at_s: Floats) -> Floats:
    """Columns of `values` (R, m) at other times; NaN outside the record."""
    columns = [np.interp(at_s, time_s, column, left=np.nan, right=np.nan) for column in values.T]
    return np.stack(columns, axis=1)


def find_offset(reference_s: Floats, reference: Floats, other_s: Floats, other: Floats) -> Offset | None:
    """Offset that minimises the mean square difference of two signals (R, m), their means taken off; None: no overlap.

    Every shift that leaves half of the shorter record in common is tried. Beyond its ends the other signal is held: a
    robot stands still before it is played and after, and so a periodic gait is not mistaken by a whole cycle.
    """
    keep = np.isfinite(reference).all(axis=1)
    t, signal = reference_s[keep], reference[keep]
    if len(t) < 8 or len(other_s) < 8 or signal.std() == 0 or other.std() == 0:
        return None
    half = 0.5 * min(t[-1] - t[0], other_s[-1] - other_s[0])
    low, high = t[0] - other_s[-1] + half, t[-1] - other_s[0] - half
    coarse_t = np.arange(t[0], t[-1], GRID_S)
    coarse = interpolate(t, signal, coarse_t)
    coarse -= coarse.mean(axis=0)
    shifts = np.arange(low, high + GRID_S, GRID_S)
    best = shifts[int(np.argmin([_held_cost(shift, coarse_t, coarse, other_s, other) for shift in shifts]))]
    found = minimize_scalar(
        _cost, bounds=(best - GRID_S, best + GRID_S), args=(t, signal, other_s, other), method="bounded",
        options={"xatol": 1e-6},
    )  # fmt: skip
    shift = float(found.x)
    a, b = _common(shift, t, signal, other_s, other)
    scale = np.sqrt((a**2).sum() * (b**2).sum())
    correlation = float((a * b).sum() / scale) if scale > 0 else 0.0
    return Offset(shift, correlation, float(np.sqrt(np.mean((a - b) ** 2))))


def _held_cost(shift: float, t: Floats, signal: Floats, other_s: Floats, other: Floats) -> float:
    moved = np.stack([np.interp(t, other_s + shift, column) for column in other.T], axis=1)
    return float(((signal - moved + moved.mean(axis=0)) ** 2).sum())


def _common(shift: float, t: Floats, signal: Floats, other_s: Floats, other: Floats) -> tuple[Floats, Floats]:
    moved = interpolate(other_s + shift, other, t)
    both = np.isfinite(moved).all(axis=1)
    a, b = signal[both], moved[both]
    return a - a.mean(axis=0), b - b.mean(axis=0)


def _cost(shift: float, t: Floats, signal: Floats, other_s: Floats, other: Floats) -> float:
    a, b = _common(shift, t, signal, other_s, other)
    return float(((a - b) ** 2).mean()) if len(a) >= 4 else np.inf
