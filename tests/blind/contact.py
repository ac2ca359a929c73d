"""Balance of the forces at the contact points, at any number S of instants at once.

Body-frame velocity xi = (V_x, V_y, omega) of the weighted centroid and the mean edge angle.
Contact point c_k with direction T_k: v_t = G_t xi + g_t with G_t = (T_x, T_y, c x T), and alike for the normal.

    0 = Q(xi) = sum_k G_k^T f_k(G_k xi + g_k) + Q_external - (change of momentum per time)

A pair of wheels on an axle adds a third row, the scrub: half-track times turning rate, G_s = (0, 0, half-track).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from blind.ground import CREEP, Ground
from blind.snake import Floats, Shape

ROUNDING = 1e-12  # of a slope: forces over speeds
SETTLED = 1e-8  # m/s, forces left over that count as balanced
SOFTENED = CREEP * 2.0 ** np.arange(9, -0.1, -0.25)  # m/s


@dataclass(frozen=True)
class Contacts:
    """g_matrix (S, 2N, 3): tangents, then normals; g (S, 2N); r (S, N, 2) vertices in the body frame.

    3N rows where wheels have a track: the scrubs come last.
    """

    g_matrix: Floats
    g: Floats
    r: Floats


def contacts(s: Shape, ground: Ground) -> Contacts:
    c, c_rate = s.r, s.r_rate
    if ground.contact_offset:
        behind = np.r_[0.0, np.full(s.r.shape[-2] - 2, ground.contact_offset), 0.0]
        tangent = np.stack([np.cos(s.tau), np.sin(s.tau)], axis=-1)
        normal = np.stack([-np.sin(s.tau), np.cos(s.tau)], axis=-1)
        c = c - behind[:, None] * tangent
        c_rate = c_rate - (behind * s.tau_rate)[..., None] * normal
    wheel = s.tau - ground.mount * s.bend / 2 + ground.toe
    x, y = np.cos(wheel), np.sin(wheel)
    rows_t = np.stack([x, y, c[..., 0] * y - c[..., 1] * x], axis=-1)
    rows_n = np.stack([-y, x, c[..., 0] * x + c[..., 1] * y], axis=-1)
    g_t = x * c_rate[..., 0] + y * c_rate[..., 1]
    g_n = -y * c_rate[..., 0] + x * c_rate[..., 1]
    rows, constants = [rows_t, rows_n], [g_t, g_n]
    if ground.half_track:
        rows.append(np.broadcast_to([0.0, 0.0, ground.half_track], rows_t.shape))
        constants.append(ground.half_track * (s.tau_rate - ground.mount * s.bend_rate / 2))
    return Contacts(np.concatenate(rows, axis=-2), np.concatenate(constants, axis=-1), s.r)


@dataclass(frozen=True)
class Momentum:
    """Implicit midpoint: momentum(xi) - known = (h / 2) forces. matrix (S, 3, 3), constant (S, 3)."""

    matrix: Floats
    constant: Floats
    half_step: Floats


def _by_kind(values: Floats, n: int) -> list[Floats]:
    """Tangential, normal and, if there is a track, scrub part (S, n, ...) of rows (S, 2n or 3n, ...)."""
    return [values[:, i : i + n] for i in range(0, values.shape[1], n)]


def _drag(ground: Ground, k: Contacts, level: Floats, rolling: Floats, xi: Floats) -> tuple[Floats, Floats]:
    v = np.einsum("sij,sj->si", k.g_matrix, xi) + k.g
    return v, np.concatenate(ground.force(level, rolling, *_by_kind(v, level.shape[-1])), axis=-1)


def _slope(ground: Ground, k: Contacts, level: Floats, rolling: Floats, v: Floats, f: Floats) -> Floats:
    """dQ/dxi (S, 3, 3) by differences of the (local) force law."""
    n, h = level.shape[-1], 1e-7
    velocities, forces = _by_kind(v, n), _by_kind(f, n)
    rows = [np.zeros_like(g) for g in _by_kind(k.g_matrix, n)]
    for j, g in enumerate(_by_kind(k.g_matrix, n)):
        moved = ground.force(level, rolling, *(u + h if i == j else u for i, u in enumerate(velocities)))
        for row, new, old in zip(rows, moved, forces, strict=True):
            row += ((new - old) / h)[..., None] * g
    return np.swapaxes(k.g_matrix, -1, -2) @ np.concatenate(rows, axis=-2)


def _residual(k: Contacts, f: Floats, external: Floats, xi: Floats, m: Momentum | None) -> Floats:
    q = np.einsum("sij,si->sj", k.g_matrix, f) + external
    if m is None:
        return q
    return q - (np.einsum("sij,sj->si", m.matrix, xi) + m.constant) / m.half_step[:, None]


def _linear_balance(k: Contacts, level: Floats, tangential: Floats, external: Floats, m: Momentum | None) -> Floats:
    across = k.g.shape[-1] // level.shape[-1] - 1
    drag = np.concatenate([level * tangential, *[level] * across], axis=-1)
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
    rolling: Floats,
    external: Floats,
    momentum: Momentum | None = None,
    guess: Floats | None = None,
) -> Floats:
    """Body velocities xi (S, 3) that balance all forces; damped Newton where the law is not linear.

    Laws that resist less the faster a wheel goes, or jump with its side, have folds where Newton stalls. There the law
    is softened and sharpened again step by step, which leads around most folds.
    """
    tangential = rolling + ground.locked
    if ground.linear:
        return _linear_balance(k, level, tangential, external, momentum)
    xi = _linear_balance(k, level, tangential, external, momentum) if guess is None else guess
    xi, left = _newton(ground, k, level, rolling, external, momentum, xi)
    stalled = np.flatnonzero(left > SETTLED)
    if len(stalled) == 0:
        return xi
    kk, ll, rr, ext = _take(k, stalled), level[stalled], rolling[stalled], external[stalled]
    m = _taken(momentum, stalled)
    around = _linear_balance(kk, ll, tangential[stalled], ext, m)
    for creep in SOFTENED:
        around, now = _newton(replace(ground, creep=float(creep)), kk, ll, rr, ext, m, around)
    better = now < left[stalled]
    xi[stalled[better]] = around[better]
    return xi


def _taken(m: Momentum | None, i: np.ndarray) -> Momentum | None:
    return m and Momentum(m.matrix[i], m.constant[i], m.half_step[i])


def _newton(
    ground: Ground,
    k: Contacts,
    level: Floats,
    rolling: Floats,
    external: Floats,
    momentum: Momentum | None,
    xi: Floats,
) -> tuple[Floats, Floats]:
    """xi (S, 3) improved from the given one, and the size (S,) of what is left over."""
    xi, left = xi.copy(), np.zeros(len(xi))
    todo = np.arange(len(xi))
    damping = np.ones(len(xi))
    for _ in range(80):
        kk, ll, ee, xx, ext = _take(k, todo), level[todo], rolling[todo], xi[todo], external[todo]
        m = _taken(momentum, todo)
        v, f = _drag(ground, kk, ll, ee, xx)
        r = _residual(kk, f, ext, xx, m)
        slope = _slope(ground, kk, ll, ee, v, f)
        if m is not None:
            slope = slope - m.matrix / m.half_step[:, None, None]
        step = -np.linalg.solve(slope - ROUNDING * np.eye(3), r[..., None])[..., 0]  # dry friction may be flat
        size = np.linalg.norm(r, axis=1)
        trial = xx + damping[todo, None] * step
        after = np.linalg.norm(_residual(kk, _drag(ground, kk, ll, ee, trial)[1], ext, trial, m), axis=1)
        better = after < size
        xi[todo[better]] = trial[better]
        left[todo] = np.where(better, after, size)
        damping[todo] = np.where(better, np.minimum(1.0, 2 * damping[todo]), damping[todo] / 3)
        still = (np.abs(step).max(axis=1) > 1e-9) & (damping[todo] > 1e-6)
        todo = todo[still]
        if len(todo) == 0:
            break
    return xi, left
