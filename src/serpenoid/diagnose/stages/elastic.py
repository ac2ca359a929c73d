"""Joints that give way in proportion to the torque that drag makes there: an elastic part between servo and link.

    d_t = a tau_side(t) + b tau_along(t) + c + left,    RMS left < LAW_ERROR RMS (d - mean d),    a > 0

d: what markers show of the joint beyond its readings; tau: the torque about the joint of linear drag sideways and along
at the vertices on its shorter side, by speeds over the time that poses are averaged over. b / a is eps, which is not
known yet. RMS: of what lasts from frame to frame. No effect of the catalogue has such a joint, so it is told in words.

Legend: F frames, N vertices, m joints.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.signal import savgol_filter

from serpenoid.body import Body, Floats
from serpenoid.diagnose.data.geometry import placed, register, shapes
from serpenoid.diagnose.data.observation import Observation
from serpenoid.diagnose.data.recording import Recording
from serpenoid.diagnose.inference.law_error import LAW_ERROR
from serpenoid.diagnose.stages.beyond_readings import Beyond, beyond, lasting
from serpenoid.diagnose.stages.marker_evidence import AVERAGED_S

PARABOLA = 2  # degree of the curve through successive frames, whose slope is a speed


def elastic(
    recordings: Sequence[Recording], shown: Sequence[Recording], seen: Observation, joints: Sequence[int]
) -> list[tuple[int, float]]:
    """Which of some joints (from 0) are, and how much of what markers show there load does not make (a share of RMS).

    seen: the observation model beside which markers show it; shown: the recordings with shapes as markers show them.
    """
    found = []
    acting = [torques(r, seen) for r in shown]
    for joint in joints:
        share = unexplained([beyond(r, seen, joint) for r in recordings], [x[:, joint] for x in acting])
        if share < LAW_ERROR:
            found.append((joint, share))
    return found


def unexplained(trials: Sequence[Beyond], acting: Sequence[Floats]) -> float:
    """How much of what markers show in each trial is not in proportion to torques (all frames, 2), as a share of its
    RMS; 1 where a joint would give way against the load."""
    by = [np.column_stack([x[t.frames], np.ones(len(t.frames))]) for t, x in zip(trials, acting, strict=True)]
    known = [np.isfinite(x).all(axis=1) for x in by]
    rows, every = (
        np.concatenate([x[k] for x, k in zip(of, known, strict=True)]) for of in (by, [t.shown for t in trials])
    )
    if len(every) <= rows.shape[1]:
        return 1.0
    numbers = np.linalg.lstsq(rows, every, rcond=None)[0]
    left = [np.where(k, t.shown - x @ numbers, 0.0) for t, x, k in zip(trials, by, known, strict=True)]
    whole = lasting([t.shown - every.mean() for t in trials], trials)
    if whole <= 0 or numbers[0] <= 0:
        return 1.0
    return float(np.sqrt(max(lasting(left, trials), 0.0) / whole))


def torques(r: Recording, seen: Observation) -> Floats:
    """About each joint (F, m, 2), of drag sideways and along, all of it 1 sideways; NaN where no pose is known."""
    points = shapes(r.body, r.angles)
    there = placed(points, register(points, seen.unstretched(r.markers))[0])
    odd = max(int(round(AVERAGED_S / r.frame_s)) | 1, PARABOLA + 1)
    moved = savgol_filter(there, odd, PARABOLA, deriv=1, delta=r.frame_s, axis=0)
    along = _tangents(there)
    side = np.stack([-along[..., 1], along[..., 0]], axis=-1)
    drag = [-(moved * way).sum(axis=-1, keepdims=True) * way * r.body.vertex_weights[:, None] for way in (side, along)]
    return np.stack([_about_joints(r.body, there, force) for force in drag], axis=-1)


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
