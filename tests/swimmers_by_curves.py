"""Bodies in a medium that resists slip across them K times as much as along: smooth curves, by Gauss quadrature.

No pieces, no steps of the package: shapes and their rates in closed form, integrals along the body exact to rounding,
motion in time by splines over eight times as many moments as there are frames.

Legend: Q nodes, T moments, F frames, N points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

NODES, OFTEN = 64, 8


@dataclass(frozen=True)
class Curve:
    """Tangent angle = amplitude sin(2 pi (t + waves s)) + turn sin(1.3 t) (2 s - 1), t in beats."""

    ratio: float  # K
    waves: float
    amplitude: float
    turn: float = 0.2

    def film(self, points: int, frames: int, beats: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times (F,) [beats], points (F, N, 2) [body lengths] and mean directions between them (F, N - 1)."""
        node, weight = np.polynomial.legendre.leggauss(NODES)
        s, weight = (node + 1) / 2, weight / 2
        along, ends = _integrals(s), _integrals(np.linspace(0, 1, points))
        t = np.linspace(0, beats, (frames - 1) * OFTEN + 1)
        phase, slow = 2 * np.pi * (t[:, None] + self.waves * s), 2 * s - 1
        angle = self.amplitude * np.sin(phase) + self.turn * np.sin(1.3 * t)[:, None] * slow
        rate = self.amplitude * 2 * np.pi * np.cos(phase) + self.turn * 1.3 * np.cos(1.3 * t)[:, None] * slow
        tangent, normal = np.stack([np.cos(angle), np.sin(angle)]), np.stack([-np.sin(angle), np.cos(angle)])
        place, bending = tangent @ along.T, (normal * rate) @ along.T
        place, bending = (v - (v @ weight)[..., None] for v in (place, bending))
        resist, thrust = np.zeros((len(t), 3, 3)), np.zeros((len(t), 3))
        for drag, way in ((1.0, tangent), (self.ratio, normal)):
            moves = np.stack([way[0], way[1], place[0] * way[1] - place[1] * way[0]])
            resist += drag * np.einsum("atq,btq,q->tab", moves, moves, weight)
            thrust += drag * np.einsum("atq,ctq,ctq,q->ta", moves, bending, way, weight)
        velocity = -np.linalg.solve(resist, thrust[..., None])[..., 0]
        heading = CubicSpline(t, velocity[:, 2]).antiderivative()(t)
        cos, sin = np.cos(heading), np.sin(heading)
        speed = np.stack([cos * velocity[:, 0] - sin * velocity[:, 1], sin * velocity[:, 0] + cos * velocity[:, 1]])
        centre = CubicSpline(t, speed.T).antiderivative()(t)
        drawn = tangent @ ends.T - (tangent @ along.T @ weight)[..., None]
        seen = np.stack([cos[:, None] * drawn[0] - sin[:, None] * drawn[1],
                         sin[:, None] * drawn[0] + cos[:, None] * drawn[1]], axis=2)  # fmt: skip
        mean = np.diff(angle @ ends.T, axis=1) * (points - 1) + heading[:, None]
        return t[::OFTEN], (seen + centre[:, None])[::OFTEN], mean[::OFTEN]


def _integrals(to: np.ndarray) -> np.ndarray:
    """What integrates, from 0 to each place, a function that is known at the nodes."""
    node, _ = np.polynomial.legendre.leggauss(NODES)
    values = np.polynomial.legendre.legvander(2 * to - 1, NODES)
    order = np.arange(1, NODES)
    integrals = np.column_stack([to, (values[:, 2:] - values[:, :-2]) / (2 * order + 1) / 2])
    return integrals @ np.linalg.inv(np.polynomial.legendre.legvander(node, NODES - 1))
