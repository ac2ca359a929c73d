"""Lengths that no two markers show: where a servo log says how joints turn, films say how long links between them are.

    q_k = c + R(psi) sum over s before k of L_s u(theta_s + zeros of the joints before s)      of every frame

Stretches s lie between successive joints and markers. Lengths and zeros are fitted to the frames of all films at once,
each frame laid where it fits best; what is told is where they begin, and what little motion leaves open stays there.

Legend: F frames, K markers, S stretches, m joints; lengths in body lengths.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Body
from serpenoid.measure.cells import Floats
from serpenoid.measure.consistency.geometry import SCALE_SD
from serpenoid.measure.consistency.lengths import Shown, one_longer
from serpenoid.measure.servo_alignment import joints_unseen
from serpenoid.measure.shapes.links import laid_over
from serpenoid.measure.trial import Trial

MOST_FRAMES = 120  # of a film, evenly chosen: postures decide
ROUNDS = 6  # of Gauss and Newton's
ZERO_SD = 0.1  # rad: of what a joint's zero may be off, beforehand


def hidden_lengths(body: Body, trials: Sequence[Trial]) -> str:
    """What is said where films and servo logs together show one link, or one stretch of it, of another length than
    `edge_lengths` says; else ""."""
    films = [found for trial in trials if (found := _postures(body, trial)) is not None]
    if body.is_animal or not films:
        return ""
    shown = np.flatnonzero(np.all([np.isfinite(points[..., 0]).any(axis=0) for points, _ in films], axis=0))
    at = np.array(sorted({*shown.tolist(), *(j for j in body.joint_vertices if shown[0] < j < shown[-1])}))
    along = np.concatenate([[0.0], np.cumsum(body.edges)])
    told = np.diff(along[at])
    fitted, covariance = _fitted(body, films, shown, at, told)
    links = np.searchsorted(body.joint_vertices, at[:-1], side="right")
    for group in (links, np.arange(len(told))):
        which = np.unique(group)
        sums = np.array([[(group == g) @ x for x in (told, fitted)] for g in which])
        unsure = np.sqrt([(group == g) @ covariance @ (group == g) for g in which]) / sums[:, 0]
        known = unsure < SCALE_SD
        one = one_longer(Shown(known, np.log(sums[known, 1] / sums[known, 0]), unsure[known] ** 2))
        if one is not None:
            mine = np.flatnonzero(group == which[one[0]])
            ends = int(at[mine[0]]), int(at[mine[-1] + 1])
            return _said(ends, sums[one[0]] * body.total_length_m, whole=group is links)
    return ""


def _said(ends: tuple[int, int], lengths: Floats, whole: bool) -> str:
    told, shown = lengths
    others = "other links are as said" if whole else "all else is as said (is a marker beside its place?)"
    return (
        f"films and servo logs together show {shown:.4g} m from vertex {ends[0]} to vertex {ends[1]}, and "
        f"`edge_lengths` says {told:.4g}, while {others}. Left so it counts as marker noise and moves what is fitted. "
        "Correct `edge_lengths` between the two"
    )


def _postures(body: Body, trial: Trial) -> tuple[Floats, Floats] | None:
    """Markers (F, N, 2) and joint angles (F, m) of frames that know both, of a film that leaves joints to the log."""
    if trial.motion is None or trial.servo is None or trial.servo_log is None:
        return None
    if not joints_unseen(body, trial.motion.markers):
        return None
    markers, angles = trial.motion.markers, trial.servo.angles
    ever = np.isfinite(markers[..., 0]).any(axis=0)
    whole = np.flatnonzero(np.isfinite(markers[:, ever, 0]).all(axis=1) & np.isfinite(angles).all(axis=1))
    if len(whole) < 2:
        return None
    some = whole[np.unique(np.linspace(0, len(whole) - 1, MOST_FRAMES).astype(int))]
    return markers[some], angles[some]


def _fitted(
    body: Body, films: Sequence[tuple[Floats, Floats]], shown: NDArray[np.int64], at: NDArray[np.int64], told: Floats
) -> tuple[Floats, Floats]:
    """Lengths of the stretches between vertices `at` (S,), and their covariance (S, S); zeros are each film's own."""
    count, joints = len(told), body.joint_count
    turned = np.searchsorted(body.joint_vertices, at[:-1], side="right")  # how many joints lie before a stretch
    behind = (at[None, 1:] <= shown[:, None]).astype(float)  # (K, S)
    lengths, zeros = np.asarray(told).copy(), np.zeros((len(films), joints))
    size = count + zeros.size
    prior = np.concatenate([1 / told**2, np.full(zeros.size, 1 / ZERO_SD**2)])
    covariance = np.zeros((size, size))
    for _ in range(ROUNDS):
        normal, slope, square, numbers = np.zeros((size, size)), np.zeros(size), 0.0, 0
        for i, (points, angles) in enumerate(films):
            left, moved = _missed(behind, turned, lengths, points[:, shown], angles + zeros[i])
            own = np.concatenate([np.arange(count), count + joints * i + np.arange(joints)])
            normal[np.ix_(own, own)] += moved.T @ moved
            slope[own] += moved.T @ left
            square, numbers = square + float(left @ left), numbers + len(left) - 3 * len(points)
        noise = max(square / max(numbers - size, 1), np.finfo(float).tiny)
        away = np.concatenate([lengths - told, zeros.ravel()])
        covariance = np.asarray(np.linalg.inv(normal / noise + np.diag(prior)), dtype=np.float64)
        step = covariance @ (slope / noise - prior * away)
        lengths += step[:count]
        zeros += step[count:].reshape(zeros.shape)
    return lengths, covariance[:count, :count]


def _missed(
    behind: Floats, turned: NDArray[np.int64], lengths: Floats, points: Floats, angles: Floats
) -> tuple[Floats, Floats]:
    """What markers (F, K, 2) miss of the chain laid over them, and how that changes with lengths and zeros, as rows;
    what another place and heading of a frame makes of either is taken off."""
    heading = np.concatenate([np.zeros((len(angles), 1)), np.cumsum(angles, axis=1)], axis=1)[:, turned]
    unit = np.stack([np.cos(heading), np.sin(heading)], axis=2)  # (F, S, 2)
    normal = np.stack([-unit[..., 1], unit[..., 0]], axis=2)
    chain = np.einsum("ks,s,fsx->fkx", behind, lengths, unit)
    turn, mid, middle = laid_over(chain, points)
    back = np.stack([np.cos(turn), np.sin(turn), -np.sin(turn), np.cos(turn)], axis=1).reshape(-1, 2, 2)
    left = np.einsum("fxy,fky->fkx", back, points - middle[:, None]) - (chain - mid[:, None])
    by_length = np.einsum("ks,fsx->fkxs", behind, unit)
    after = (turned[:, None] > np.arange(angles.shape[1])).astype(float)  # (S, m)
    by_zero = np.einsum("ks,s,fsx,sj->fkxj", behind, lengths, normal, after)
    moved = np.concatenate([by_length, by_zero], axis=3)
    moved -= moved.mean(axis=1, keepdims=True)
    about = chain - mid[:, None]
    spin = np.stack([-about[..., 1], about[..., 0]], axis=2)
    spin /= np.sqrt((spin**2).sum(axis=(1, 2), keepdims=True))
    moved -= spin[..., None] * np.einsum("fkx,fkxp->fp", spin, moved)[:, None, None]
    return left.ravel(), moved.reshape(left.size, -1)
