"""Anisotropic drag of one degree d by plain minimisation: NumPy and SciPy, no shared code. Coulomb friction: d = 1.

    E(g) = sum_k w_k q_k^(d/2) / d   ->   min over the second pose g
    q = |dp|^2 + (eps^(2/d) - 1)/2 (<dp, T>^2 + <dp, T'>^2)

By components, each way on its own: E(g) = sum_k w_k (n_k^(d/2) + eps a_k^(d/2)) / d, where n and a are the parts of
|dp|^2 across and along.

Not softened: a step's minimum is found by BFGS on the (for d = 1 kinked) energy with its gradient by hand, from several
starts.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize

from oracle.chain import Floats, place, shape_vertices, vertex_tangents
from oracle.integrator import Run, cross

STARTS = (1.0, 0.7, 1.3)


def step_energy(g: Floats, p0: Floats, shape: Floats, w: Floats, eps: float, degree: int) -> tuple[float, Floats]:
    """Energy of a step that ends at pose g, and its gradient by g."""
    p1 = place(g, shape)
    t0, t1 = vertex_tangents(p0), vertex_tangents(p1)
    dp = p1 - p0
    a0, a1 = np.sum(dp * t0, axis=1), np.sum(dp * t1, axis=1)
    less = eps ** (2 / degree) - 1
    q = np.maximum(np.sum(dp * dp, axis=1) + less / 2 * (a0**2 + a1**2), 1e-300)
    d0, d1 = dp + less * a0[:, None] * t0, dp + less * a1[:, None] * t1
    share = (w * q ** (degree / 2 - 1))[:, None]
    pull = np.sum(share * (d0 + d1) / 2, axis=0)
    turn = np.sum(share[:, 0] * (cross(p1, d0) + cross(p0, d1))) / 2  # about the world's origin
    return float(w @ q ** (degree / 2)) / degree, np.array([*pull, turn - (g[0] * pull[1] - g[1] * pull[0])])


def energy_by_components(
    g: Floats, p0: Floats, shape: Floats, w: Floats, eps: float, degree: int
) -> tuple[float, Floats]:
    """The same, each way on its own."""
    p1 = place(g, shape)
    t0, t1 = vertex_tangents(p0), vertex_tangents(p1)
    dp = p1 - p0
    a0, a1 = np.sum(dp * t0, axis=1), np.sum(dp * t1, axis=1)
    along = np.maximum((a0**2 + a1**2) / 2, 1e-300)
    across = np.maximum(np.sum(dp * dp, axis=1) - along, 1e-300)
    m_across, m_along = (w * across ** (degree / 2 - 1))[:, None], (eps * w * along ** (degree / 2 - 1))[:, None]
    f0, f1 = (m_across * (dp - a[:, None] * t) + m_along * a[:, None] * t for a, t in ((a0, t0), (a1, t1)))
    pull = np.sum(f0 + f1, axis=0) / 2
    turn = np.sum(cross(p1, f0) + cross(p0, f1)) / 2
    value = float(w @ (across ** (degree / 2) + eps * along ** (degree / 2))) / degree
    return value, np.array([*pull, turn - (g[0] * pull[1] - g[1] * pull[0])])


def simulate(
    table: ArrayLike, edges: ArrayLike, weights: ArrayLike, eps: float, degree: int, by_components: bool = False
) -> Run:
    """Lay the shapes of a closed joint table (T, m) one after another; vertex dissipation."""
    lengths = np.asarray(edges, float) / np.sum(edges)
    w = np.asarray(weights, float) / np.sum(weights)
    energy = energy_by_components if by_components else step_energy
    rows = np.concatenate([np.asarray(table, float), np.asarray(table, float)[:1]])
    shapes = shape_vertices(rows, lengths, w, None)
    pose, move = np.zeros(3), np.zeros(3)
    poses, placed, energies = [pose], [shapes[0]], []
    for shape in shapes[1:]:
        here = placed[-1] - pose[:2]

        def cost(x: Floats, here=here, shape=shape, heading=pose[2]):  # type: ignore[no-untyped-def]
            return energy(np.array([x[0], x[1], heading + x[2]]), here, shape, w, eps, degree)

        found = [minimize(cost, f * move, jac=True, method="BFGS", options={"gtol": 1e-10}) for f in STARTS]
        best = min(found, key=lambda r: r.fun)
        move = best.x
        pose = pose + move
        poses.append(pose)
        placed.append(place(pose, shape))
        energies.append(best.fun)
    return Run(np.array(poses), np.array(placed), np.array(energies))
