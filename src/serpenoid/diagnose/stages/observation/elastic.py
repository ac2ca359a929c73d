"""Joints that give way in proportion to the torque that drag makes there: an elastic part between servo and link.

    d_t = a tau_side(t) + b tau_along(t) + c + s theta'(t) + left,    a > 0,    left < LAW_ERROR of left without tau

d: what markers show of the joint beyond its readings theta; tau: the torque about the joint of linear drag sideways and
along at the vertices on its shorter side, by speeds over the time that poses are averaged over. b / a is eps, which is
not known yet. s: what the clocks of a trial are off by; where all joints give way, clocks are laid over what these
share. Sizes are RMS of what lasts from frame to frame. No effect of the catalogue has such a joint: it is told in
words.

Legend: F frames, N vertices, m joints, T trials.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.body import Body, Floats
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.shapes.geometry import placed, register, shapes
from serpenoid.diagnose.data.shapes.smooth import AVERAGED_S
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR
from serpenoid.diagnose.inference.fits.finding import VISIBLE
from serpenoid.diagnose.stages.observation.beyond_readings import Beyond, OfJoint, lasting, noise_level


def elastic(
    trials: Sequence[Beyond], shown: Sequence[Recording], seen: Observation, joints: Sequence[int]
) -> list[tuple[int, float]]:
    """Which of some joints (from 0) are, and how much of what markers show there load does not make (a share of RMS).

    seen: the observation model beside which markers show it; shown: the recordings with shapes as markers show them.
    """
    if not joints:
        return []
    found = []
    acting = [torques(r, seen) for r in shown]
    for joint in joints:
        speeds = [np.gradient(t.recording.angles[:, joint], t.recording.time) for t in trials]
        acted = [x[:, joint] for x in acting]
        share = unexplained([t.at(joint) for t in trials], acted, speeds, noise_level(trials, joint))
        if share < LAW_ERROR:
            found.append((joint, share))
    return found


def unexplained(trials: Sequence[OfJoint], acting: Sequence[Floats], speeds: Sequence[Floats], level: float) -> float:
    """How much of what markers show in each trial is not in proportion to torques (all frames, 2), as a share of the
    RMS that clocks leave beside a reading's speeds (all frames,); 1 where a joint would give way against the load, or
    clocks leave no more than the noise level [rad]."""
    clocks = np.eye(len(trials))
    alone = [
        np.column_stack([np.ones(len(t.frames)), np.outer(speed[t.frames], own)])
        for t, speed, own in zip(trials, speeds, clocks, strict=True)
    ]
    with_load = [np.column_stack([x[t.frames], rest]) for t, x, rest in zip(trials, acting, alone, strict=True)]
    known = [np.isfinite(x).all(axis=1) for x in with_load]
    (by_clocks, _), (left, numbers) = (_left(trials, x, known) for x in (alone, with_load))
    whole = lasting(by_clocks, trials)
    if whole <= (VISIBLE * level) ** 2 or numbers[0] <= 0:
        return 1.0
    return float(np.sqrt(max(lasting(left, trials), 0.0) / whole))


def _left(
    trials: Sequence[OfJoint], rows: Sequence[Floats], known: Sequence[np.ndarray]
) -> tuple[list[Floats], Floats]:
    """What least squares leave of each trial by columns (F, C), 0 where these are not known, and their numbers (C,)."""
    some = np.concatenate([x[k] for x, k in zip(rows, known, strict=True)])
    every = np.concatenate([t.shown[k] for t, k in zip(trials, known, strict=True)])
    numbers = np.linalg.lstsq(some, every, rcond=None)[0]
    left = [np.where(k, t.shown - x @ numbers, 0.0) for t, x, k in zip(trials, rows, known, strict=True)]
    return left, numbers


def torques(r: Recording, seen: Observation) -> Floats:
    """About each joint (F, m, 2), of drag sideways and along, all of it 1 sideways; NaN where no pose is known."""
    points = shapes(r.body, r.angles)
    there = placed(points, register(points, seen.unstretched(r.markers))[0])
    moved = _speeds(there, max(int(AVERAGED_S / r.frame_s / 2), 1), r.frame_s)
    along = _tangents(there)
    side = np.stack([-along[..., 1], along[..., 0]], axis=-1)
    drag = [-(moved * way).sum(axis=-1, keepdims=True) * way * r.body.vertex_weights[:, None] for way in (side, along)]
    return np.stack([_about_joints(r.body, there, force) for force in drag], axis=-1)


def _speeds(points: Floats, reach: int, frame_s: float) -> Floats:
    """Slopes (F, N, 2) of the straight lines, or parabolas, through as many frames on either side; NaN at the ends."""
    found, by = np.full_like(points, np.nan), np.arange(-reach, reach + 1)
    if len(points) > 2 * reach:
        around = np.lib.stride_tricks.sliding_window_view(points, len(by), axis=0)
        found[reach:-reach] = around @ by / (by @ by * frame_s)
    return found


def _tangents(points: Floats) -> Floats:
    """Unit vectors (F, N, 2): amid those of the edges at each vertex."""
    edges = np.diff(points, axis=1)
    edges /= np.linalg.norm(edges, axis=2, keepdims=True)
    both = np.concatenate([edges[:, :1], edges[:, :-1] + edges[:, 1:], edges[:, -1:]], axis=1)
    return np.asarray(both / np.linalg.norm(both, axis=2, keepdims=True))


def _about_joints(body: Body, points: Floats, force: Floats) -> Floats:
    """Torque (F, m) of forces (F, N, 2) on the head's side of each joint, by those on the shorter side: all of them
    together are none."""
    found = np.zeros((len(points), body.joint_count))
    for joint, vertex in enumerate(body.joint_vertices):
        arm = points - points[:, vertex : vertex + 1]
        moment = arm[..., 0] * force[..., 1] - arm[..., 1] * force[..., 0]
        to_head = vertex >= body.vertices / 2
        found[:, joint] = moment[:, vertex + 1 :].sum(axis=1) if to_head else -moment[:, :vertex].sum(axis=1)
    return found
