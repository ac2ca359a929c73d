"""Swimmers of N equal links, small strokes about the straight body: what the way is worth, and the cheapest stroke.

Small joint angles a cos 2 pi t + b sin 2 pi t move the body by a.S b with S antisymmetric and dissipate a.G a + b.G b
with G symmetric and positive. The cheapest stroke per way is the first singular pair of S measured by G, an ellipse in
one plane of the joint angles, whatever N (Alouges, DeSimone, Giraldi, Or & Wiezel 2019).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from oracle.chain import Floats
from oracle.integrator import simulate

SMALL = 0.005  # rad: terms of the fourth order in the angles are 3e-5 of those of the second


@dataclass(frozen=True)
class Cheapest:
    """energy: least dissipation T E per body length; plane (2, N - 1): joint angles a and b of unit G-norm."""

    energy: float
    plane: Floats

    @property
    def lags(self) -> Floats:
        """By how much each joint follows the one towards the tail [degrees], shape (N - 2,)."""
        phase = np.angle(self.plane[0] - 1j * self.plane[1])
        return np.rad2deg(np.angle(np.exp(1j * np.diff(phase))))


def cheapest_stroke(links: int, per_link: int, eps: float, steps: int = 12) -> Cheapest:
    """Of a swimmer of `links` equal links with `per_link` edges each, edge dissipation, `steps` steps in a cycle."""
    edges, count = links * per_link, links - 1
    weights = np.full(edges + 1, 1.0)
    weights[[0, -1]] = 0.5
    bends, phase = tuple(per_link * np.arange(1, links)), 2 * np.pi * np.arange(steps)[:, None] / steps

    def run(a: Floats, b: Floats) -> tuple[float, float]:
        table = SMALL * (np.cos(phase) * a + np.sin(phase) * b)
        motion = simulate(table, np.ones(edges), weights, eps, dissipation="edge", joints=bends)
        return float(motion.poses[-1, 0]) / SMALL**2, motion.dissipation / SMALL**2

    s, g, unit = np.zeros((count, count)), np.zeros((count, count)), np.eye(count)
    for i in range(count):
        g[i, i] = run(unit[i], 0 * unit[i])[1]
    for i in range(count):
        for j in range(i):
            s[j, i], both = run(unit[j], unit[i])
            s[i, j] = -s[j, i]
            g[i, j] = g[j, i] = (run(unit[i] + unit[j], 0 * unit[i])[1] - g[i, i] - g[j, j]) / 2
            if abs(both - g[i, i] - g[j, j]) > 1e-2 * both:
                raise ArithmeticError("the strokes are not small: their dissipation does not add up")
    root = np.linalg.inv(np.linalg.cholesky(g))
    left, values, right = np.linalg.svd(root @ s @ root.T)
    # a.S b is largest, at |a| = |b| = 1 in the metric, with the first pair; it costs a.G a + b.G b = 2
    return Cheapest(2 / float(values[0]), np.array([root.T @ left[:, 0], root.T @ right[0]]))
