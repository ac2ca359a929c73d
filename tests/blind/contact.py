"""Balance of the forces at the contact points, at any number S of instants at once.

Body-frame velocity xi = (V_x, V_y, omega) of the weighted centroid and the mean edge angle.
Contact point c_k with direction T_k: v_t = G_t xi + g_t with G_t = (T_x, T_y, c x T), and alike for the normal.

    0 = Q(xi) = sum_k G_k^T f_k(G_k xi + g_k) + Q_external - (change of momentum per time)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from blind.ground import Ground
from blind.snake import Floats, Shape


@dataclass(frozen=True)
class Contacts:
    """g_matrix (S, 2N, 3): tangents, then normals; g (S, 2N); r (S, N, 2) vertices in the body frame."""

    g_matrix: Floats
    g: Floats
    r: Floats


def contacts(s: Shape, toe: float, offset: float) -> Contacts:
    c, c_rate = s.r, s.r_rate
    if offset:
        behind = np.r_[0.0, np.full(s.r.shape[-2] - 2, offset), 0.0]
        tangent = np.stack([np.cos(s.tau), np.sin(s.tau)], axis=-1)
        normal = np.stack([-np.sin(s.tau), np.cos(s.tau)], axis=-1)
        c = c - behind[:, None] * tangent
        c_rate = c_rate - (behind * s.tau_rate)[..., None] * normal
    x, y = np.cos(s.tau + toe), np.sin(s.tau + toe)
    rows_t = np.stack([x, y, c[..., 0] * y - c[..., 1] * x], axis=-1)
    rows_n = np.stack([-y, x, c[..., 0] * x + c[..., 1] * y], axis=-1)
    g_t = x * c_rate[..., 0] + y * c_rate[..., 1]
    g_n = -y * c_rate[..., 0] + x * c_rate[..., 1]
    return Contacts(np.concatenate([rows_t, rows_n], axis=-2), np.concatenate([g_t, g_n], axis=-1), s.r)


@dataclass(frozen=True)
class Momentum:
    """Implicit midpoint: momentum(xi) - known = (h / 2) forces. matrix (S, 3, 3), constant (S, 3)."""

    matrix: Floats
    constant: Floats
    half_step: Floats


def _drag(ground: Ground, k: Contacts, level: Floats, eps: Floats, xi: Floats) -> tuple[Floats, Floats]:
    n = level.shape[-1]
    v = np.einsum("sij,sj->si", k.g_matrix, xi) + k.g
    f_t, f_n = ground.force(level, eps, v[:, :n], v[:, n:])
    return v, np.concatenate([f_t, f_n], axis=-1)


def _slope(ground: Ground, k: Contacts, level: Floats, eps: Floats, v: Floats, f: Floats) -> Floats:
    """dQ/dxi (S, 3, 3) by differences of the (local) force law."""
    n, h = level.shape[-1], 1e-7
    gt, gn = k.g_matrix[:, :n], k.g_matrix[:, n:]
    a = ground.force(level, eps, v[:, :n] + h, v[:, n:])
    b = ground.force(level, eps, v[:, :n], v[:, n:] + h)
    tt, nt = ((a[i] - f[:, i * n : i * n + n]) / h for i in (0, 1))
    tn, nn = ((b[i] - f[:, i * n : i * n + n]) / h for i in (0, 1))
    rows = [tt[..., None] * gt + tn[..., None] * gn, nt[..., None] * gt + nn[..., None] * gn]
    return np.swapaxes(k.g_matrix, -1, -2) @ np.concatenate(rows, axis=-2)


def _residual(k: Contacts, f: Floats, external: Floats, xi: Floats, m: Momentum | None) -> Floats:
    q = np.einsum("sij,si->sj", k.g_matrix, f) + external
    if m is None:
        return q
    return q - (np.einsum("sij,sj->si", m.matrix, xi) + m.constant) / m.half_step[:, None]


def _linear_balance(k: Contacts, level: Floats, eps: Floats, external: Floats, m: Momentum | None) -> Floats:
    drag = np.concatenate([level * eps, level], axis=-1)
    weighted = drag[..., None] * k.g_matrix
    matrix = np.swapaxes(k.g_matrix, -1, -2) @ weighted
    right = external - np.einsum("sij,si->sj", weighted, k.g)
    if m is not None:
        matrix = matrix + m.matrix / m.half_step[:, None, None]
        right = right - m.constant / m.half_step[:, None]
    return np.linalg.solve(matrix, right[..., None])[..., 0]


def _take(k: Contacts, i: np.ndarray) -> Contacts:
    return Contacts(k.g_matrix[i], k.g[i], k.r[i])


def balance(
    ground: Ground,
    k: Contacts,
    level: Floats,
    eps: Floats,
    external: Floats,
    momentum: Momentum | None = None,
    guess: Floats | None = None,
) -> Floats:
    """Body velocities xi (S, 3) that balance all forces; damped Newton where the law is not linear."""
    if ground.linear:
        return _linear_balance(k, level, eps, external, momentum)
    xi = _linear_balance(k, level, eps, external, momentum) if guess is None else guess.copy()
    todo = np.arange(len(xi))
    damping = np.ones(len(xi))
    for _ in range(80):
        kk, ll, ee, xx, ext = _take(k, todo), level[todo], eps[todo], xi[todo], external[todo]
        m = momentum and Momentum(momentum.matrix[todo], momentum.constant[todo], momentum.half_step[todo])
        v, f = _drag(ground, kk, ll, ee, xx)
        r = _residual(kk, f, ext, xx, m)
        slope = _slope(ground, kk, ll, ee, v, f)
        if m is not None:
            slope = slope - m.matrix / m.half_step[:, None, None]
        step = -np.linalg.solve(slope, r[..., None])[..., 0]
        size = np.linalg.norm(r, axis=1)
        trial = xx + damping[todo, None] * step
        better = np.linalg.norm(_residual(kk, _drag(ground, kk, ll, ee, trial)[1], ext, trial, m), axis=1) < size
        xi[todo[better]] = trial[better]
        damping[todo] = np.where(better, np.minimum(1.0, 2 * damping[todo]), damping[todo] / 3)
        still = (np.abs(step).max(axis=1) > 1e-9) & (damping[todo] > 1e-6)
        todo = todo[still]
        if len(todo) == 0:
            return xi
    return xi
