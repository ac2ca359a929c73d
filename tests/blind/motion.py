"""From joint angles in time to the path of the body.

    massless    the contact forces balance at every instant
    inertial    d/dt (momentum, angular momentum about the origin) = forces and moments, by the implicit midpoint rule

Massless motion in a uniform world is solved for all instants at once. Where the force depends on place or heading, the
path is iterated to its fixed point, window by window (Picard); with inertia it is stepped, all trials side by side.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from blind.contact import Contacts, Momentum, balance, contacts
from blind.ground import Ground
from blind.snake import Floats, shape, to_world

WINDOW_S = 0.5  # Picard iteration converges the faster the shorter the stretch of time


def _to_body(vector: Floats, heading: Floats) -> Floats:
    c, s = np.cos(heading), np.sin(heading)
    while c.ndim < vector.ndim - 1:
        c, s = c[..., None], s[..., None]
    return np.stack([c * vector[..., 0] + s * vector[..., 1], -s * vector[..., 0] + c * vector[..., 1]], axis=-1)


def _world(
    ground: Ground, k: Contacts, pose: Floats, time: Floats, phase: Floats, rolling: Floats
) -> tuple[Floats, Floats, Floats]:
    """Contact levels and what rolling weighs beside them (S, N), external body-frame forces and moment (S, 3) at the
    given poses; rolling: the same where tyres grip as usual."""
    world = to_world(k.r, pose)
    bite = ground.bite(world)
    level = ground.level(world, phase) * bite
    forces = ground.external_force(world, time)
    external = np.zeros((len(pose), 3))
    if forces is not None:
        f = _to_body(forces, pose[:, 2])
        external[:, :2] = f.sum(axis=1)
        external[:, 2] = (k.r[..., 0] * f[..., 1] - k.r[..., 1] * f[..., 0]).sum(axis=1)
    return level, rolling / bite, external


def _advance(xi: Floats, h: Floats, start: Floats) -> Floats:
    """Path (n + 1, 3) of body velocities (n, 3) that hold at the middle of each step."""
    turn = np.concatenate([[start[2]], start[2] + np.cumsum(xi[:, 2] * h)])
    middle = (turn[1:] + turn[:-1]) / 2
    c, s = np.cos(middle), np.sin(middle)
    step = np.stack([c * xi[:, 0] - s * xi[:, 1], s * xi[:, 0] + c * xi[:, 1]], axis=-1) * h[:, None]
    place = np.concatenate([start[None, :2], start[:2] + np.cumsum(step, axis=0)])
    return np.column_stack([place, turn])


def _massless(
    ground: Ground, time: Floats, phi: Floats, phase: Floats, start: Floats, slip: Floats, tolerance: float
) -> Floats:
    h = np.diff(time)
    middle_time, middle_phase = (time[1:] + time[:-1]) / 2, (phase[1:] + phase[:-1]) / 2
    k = contacts(shape((phi[1:] + phi[:-1]) / 2, np.diff(phi, axis=0) / h[:, None], ground.robot), ground)
    rolling = ground.rolling(middle_time)
    windows = int(np.ceil((time[-1] - time[0]) / WINDOW_S)) if ground.knows_place else 1
    edges = np.linspace(0, len(h), windows + 1).astype(int)
    pieces = [start[None]]
    for a, b in zip(edges[:-1], edges[1:], strict=True):
        part = slice(a, b)

        def improved(path: Floats, xi: Floats | None, part: slice = part) -> tuple[Floats, Floats]:
            kk = Contacts(k.g_matrix[part], k.g[part], k.r[part])
            middle = (path[1:] + path[:-1]) / 2
            level, rolls, external = _world(ground, kk, middle, middle_time[part], middle_phase[part], rolling[part])
            xi = balance(ground, kk, level, rolls, external, guess=xi)
            return _advance(xi + slip[part], h[part], path[0]), xi

        pieces.append(
            _settled(improved, np.repeat(pieces[-1][-1:], b - a + 1, axis=0), ground.knows_place, tolerance)[1:]
        )
    return np.concatenate(pieces)


def _settled(
    improved: Callable[[Floats, Floats | None], tuple[Floats, Floats]], path: Floats, repeat: bool, tolerance: float
) -> Floats:
    """Picard iteration; a single pass where nothing depends on the path."""
    xi = None
    for _ in range(100):
        new, xi = improved(path, xi)
        change = np.abs(new - path).max()
        path = new
        if not repeat or change < tolerance:
            return path
    raise ArithmeticError(f"the path did not settle: last change {change:.1e}")


def _inertial(ground: Ground, time: Floats, phi: Floats, phase: Floats, start: Floats, slip: Floats) -> Floats:
    """All trials in step: time, phase (B, n + 1), phi (B, n + 1, m), start (B, 3), slip (B, n, 3)."""
    path = np.empty((*time.shape, 3))
    path[:, 0] = start
    known = np.zeros((len(time), 3))  # momentum, angular momentum about the origin, in the world's frame
    xi = np.zeros((len(time), 3))
    carried = ground.drag_weights
    mass = np.r_[ground.inertia * carried, (ground.inertia + ground.added_mass) * carried]
    steps = np.diff(time, axis=1)
    middle_time, middle_phase = (time[:, 1:] + time[:, :-1]) / 2, (phase[:, 1:] + phase[:, :-1]) / 2
    s = shape((phi[:, 1:] + phi[:, :-1]) / 2, np.diff(phi, axis=1) / steps[..., None], ground.robot)
    touching = contacts(s, ground)
    plain = contacts(s, Ground(ground.eps, ground.robot))
    rolling = ground.rolling(middle_time)
    weighted = mass[:, None] * plain.g_matrix
    matrices = np.swapaxes(plain.g_matrix, -1, -2) @ weighted
    constants = np.einsum("bsij,bsi->bsj", weighted, plain.g)
    for i in range(steps.shape[1]):
        h, pose = steps[:, i], path[:, i]
        k = Contacts(touching.g_matrix[:, i], touching.g[:, i], touching.r[:, i])
        half = _moved(pose, xi + slip[:, i], h / 2)
        level, rolls, external = _world(ground, k, half, middle_time[:, i], middle_phase[:, i], rolling[:, i])
        linear = _to_body(known[:, :2], half[:, 2])
        about = known[:, 2] - (half[:, 0] * known[:, 1] - half[:, 1] * known[:, 0])
        old = np.column_stack([linear, about])
        m = Momentum(matrices[:, i], constants[:, i] - old, h / 2)
        xi = balance(ground, k, level, rolls, external, m, guess=xi if i else None)
        gained = 2 * (np.einsum("sij,sj->si", m.matrix, xi) + m.constant)  # impulse of the forces over the step
        c, sn = np.cos(half[:, 2]), np.sin(half[:, 2])
        px, py = c * gained[:, 0] - sn * gained[:, 1], sn * gained[:, 0] + c * gained[:, 1]
        known = known + np.column_stack([px, py, gained[:, 2] + half[:, 0] * py - half[:, 1] * px])
        path[:, i + 1] = _moved(pose, xi + slip[:, i], h)
    return path


def _moved(pose: Floats, xi: Floats, h: Floats) -> Floats:
    middle = pose[:, 2] + xi[:, 2] * h / 2
    c, s = np.cos(middle), np.sin(middle)
    step = np.column_stack([c * xi[:, 0] - s * xi[:, 1], s * xi[:, 0] + c * xi[:, 1], xi[:, 2]])
    return pose + step * h[:, None]


@dataclass(frozen=True)
class Drive:
    """One trial: time (n + 1,) [s since t0], phi (n + 1, m), phase (n + 1,) [cycles], start pose, slip (n, 3)."""

    time: Floats
    phi: Floats
    phase: Floats
    start: Floats
    slip: Floats | None = None


def _slip(d: Drive) -> Floats:
    return np.zeros((len(d.time) - 1, 3)) if d.slip is None else d.slip


def paths(ground: Ground, drives: list[Drive], tolerance: float = 1e-9) -> list[Floats]:
    """Poses (n + 1, 3) of the weighted centroid and the mean edge angle, one array per trial."""
    if not ground.inertial:
        return [_massless(ground, d.time, d.phi, d.phase, d.start, _slip(d), tolerance) for d in drives]
    longest = max(len(d.time) for d in drives)

    def padded(a: Floats) -> Floats:
        return np.concatenate([a, np.repeat(a[-1:], longest - len(a), axis=0)])

    def extended(t: Floats) -> Floats:
        more = longest - len(t)
        return np.concatenate([t, t[-1] + (t[-1] - t[-2]) * np.arange(1, more + 1)])

    slip = np.stack([np.concatenate([_slip(d), np.zeros((longest - len(d.time), 3))]) for d in drives])
    time = np.stack([extended(d.time) for d in drives])
    phi, phase = np.stack([padded(d.phi) for d in drives]), np.stack([padded(d.phase) for d in drives])
    start = np.stack([d.start for d in drives])
    found = _inertial(ground, time, phi, phase, start, slip)
    return [f[: len(d.time)] for f, d in zip(found, drives, strict=True)]
