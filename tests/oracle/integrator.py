"""Algorithm 1 of Even et al. 2024 in the plane, written by hand from the paper and solved by `scipy.optimize.root`.

    mu_rot  = sum_k p_k^{t+1} x (D_k^t dp_k) + p_k^t x (D_k^{t+1} dp_k)
    mu_tran = sum_k (D_k^{t,t+1} dp_k),   D^{t,t+1} = (D^t + D^{t+1}) / 2,   D_k = w_k (I + (eps - 1) T_k T_k^T)
    step energy = 1/2 sum_k <D_k^{t,t+1} dp_k, dp_k>

Inside: body length 1, weights sum to 1. Start pose (0, 0, 0): weighted centroid at the origin, mean edge angle 0.

Reference problem (12 vertices, 11 equal edges, w = 1/12, eps = 0.1865, T = 50, sigma = 1, a = 6, xi = 1):
displacement 0.452306484969, forward displacement +0.452305697266 (head first), no heading change, sum of the step
energies 0.001488277227, T times that 0.0744138614. T = 400: displacement 0.454480944. With `edge` dissipation
(T = 50, weights uniform per length: 1/22 at the ends, 1/11 inside): displacement 0.391798523140.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import root

from oracle.chain import Floats, edge_tangents, place, shape_vertices, vertex_tangents

REFERENCE = {"sigma": 1.0, "a": 6.0, "xi": 1.0}


@dataclass(frozen=True)
class Run:
    """poses (T + 1, 3): weighted centroid [body lengths] and mean edge angle; vertices (T + 1, N, 2); energies (T,)."""

    poses: Floats
    vertices: Floats
    energies: Floats

    @property
    def displacement(self) -> float:
        """Distance of the centroid from start to end [body lengths]."""
        return float(np.hypot(*(self.poses[-1] - self.poses[0])[:2]))

    @property
    def forward_displacement(self) -> float:
        """Displacement along the direction of the mean heading of all poses; positive = head first."""
        mean = self.poses[:, 2].mean()
        return float((self.poses[-1] - self.poses[0])[:2] @ [np.cos(mean), np.sin(mean)])

    @property
    def dissipation(self) -> float:
        """T times the sum of the step energies: converges as T grows."""
        return float(len(self.energies) * self.energies.sum())


def vertex_elements(p: Floats) -> tuple[Floats, Floats]:
    """Dissipating points and their tangents: the vertices."""
    return p, vertex_tangents(p)


def edge_elements(p: Floats) -> tuple[Floats, Floats]:
    """Dissipating points and their tangents: the midpoints of the edges."""
    return (p[:-1] + p[1:]) / 2, edge_tangents(p)


def edge_weights(weights: ArrayLike, edges: ArrayLike) -> Floats:
    """Each interior vertex gives its weight to its two edges as they are long, an end vertex all to its one edge."""
    found = np.zeros(len(np.asarray(edges)))
    for k, w in enumerate(np.asarray(weights, dtype=float)):
        mine = [j for j in (k - 1, k) if 0 <= j < len(found)]
        total = sum(float(np.asarray(edges)[j]) for j in mine)
        for j in mine:
            found[j] += w * float(np.asarray(edges)[j]) / total
    return found


def dissipation_tensors(tangents: Floats, weights: Floats, eps: float) -> Floats:
    """D_k = w_k (I + (eps - 1) T_k T_k^T), shape (K, 2, 2)."""
    outer = tangents[:, :, None] * tangents[:, None, :]
    return weights[:, None, None] * (np.eye(2) + (eps - 1) * outer)


def cross(a: Floats, b: Floats) -> Floats:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def momentum(p0: Floats, d0: Floats, p1: Floats, d1: Floats) -> Floats:
    """The paper's blocks without its factor -1/2: (mu_rot, mu_tran_x, mu_tran_y)."""
    dp = p1 - p0
    rot = cross(p1, np.einsum("kij,kj->ki", d0, dp)) + cross(p0, np.einsum("kij,kj->ki", d1, dp))
    tran = np.einsum("kij,kj->ki", (d0 + d1) / 2, dp)
    return np.array([rot.sum(), *tran.sum(axis=0)])


def step_energy(p0: Floats, d0: Floats, p1: Floats, d1: Floats) -> float:
    """1/2 sum_k <D_k^{t,t+1} dp_k, dp_k>."""
    dp = p1 - p0
    return float(0.5 * np.einsum("ki,kij,kj->", dp, (d0 + d1) / 2, dp))


def simulate(
    joint_table: ArrayLike,
    edge_lengths: ArrayLike,
    weights: ArrayLike,
    eps: float,
    *,
    dissipation: str = "vertex",
    joints: Sequence[int] | None = None,
    cycles: int = 1,
    closed: bool = True,
    start_pose: ArrayLike = (0.0, 0.0, 0.0),
) -> Run:
    """Lay the shapes of a table (T, m) [rad] one after another; a closed table returns to its row 0."""
    edges = np.asarray(edge_lengths, dtype=float) / np.sum(edge_lengths)
    w = np.asarray(weights, dtype=float) / np.sum(weights)
    table = np.asarray(joint_table, dtype=float)
    rows = np.concatenate([np.tile(table, (cycles, 1)), table[:1]]) if closed else table
    shapes = shape_vertices(rows, edges, w, joints)
    elements: Callable[[Floats], tuple[Floats, Floats]]
    elements, share = (vertex_elements, w) if dissipation == "vertex" else (edge_elements, edge_weights(w, edges))

    def tensors(p: Floats) -> tuple[Floats, Floats]:
        points, tangents = elements(p)
        return points, dissipation_tensors(tangents, share, eps)

    pose = np.asarray(start_pose, dtype=float)
    move = np.zeros(3)
    poses, placed, energies = [pose], [place(pose, shapes[0])], []
    for shape in shapes[1:]:
        old = tensors(placed[-1])
        offset = np.array([*pose[:2], 0.0])  # the momentum is taken about the old centroid, for conditioning
        here = (old[0] - offset[:2], old[1])

        def residual(g: Floats, here=here, shape=shape, heading=pose[2]) -> Floats:  # type: ignore[no-untyped-def]
            return momentum(*here, *tensors(place([g[0], g[1], heading + g[2]], shape)))

        found = root(residual, move, method="hybr", options={"xtol": 1e-14})
        if np.abs(found.fun).max() > 1e-12:
            found = root(residual, np.zeros(3), method="hybr", options={"xtol": 1e-14})
        if np.abs(found.fun).max() > 1e-12:
            raise ArithmeticError(f"no root of the momentum: residual {np.abs(found.fun).max():.1e}")
        move = found.x
        pose = pose + move
        placed.append(place(pose, shape))
        new = tensors(placed[-1])
        energies.append(step_energy(*old, *new))
        poses.append(pose)
    return Run(np.array(poses), np.array(placed), np.array(energies))
