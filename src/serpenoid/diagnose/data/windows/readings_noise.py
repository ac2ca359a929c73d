"""What the noise of servos' readings does to windows: trials that are played alike round alike, so no repeat tells it.

The shape at a boundary is off by d, joint by joint. There the model moves the body by A d, as if it had bent so far,
and the pose that carries its markers to where they are seen moves by G d, so the residual is off by (G - A) d. A window
is off by what its two ends are, whose errors are known together (shape_in_time.py).

Legend: B boundaries, m joints.
"""

from __future__ import annotations

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.shapes.geometry import register, shapes
from serpenoid.media import VISCOUS
from serpenoid.model import Model
from serpenoid.simulation.steps import elements_of_vertices, solve_steps

AVERAGED = 9  # times that stand for a stretch
BENT = 1e-4  # rad: a small step; drag is linear


def of_shapes(r: Recording, times: Floats, half: float) -> Floats:
    """Covariance (m, B, B) [rad^2] of each joint's means about times (B,) [s], from `half` before to as much after;
    zero where bends are what markers show: their noise no two trials share."""
    if r.by_markers.all():
        return np.zeros((r.body.joint_count, len(times), len(times)))
    averaged = np.linspace(times - half, np.minimum(times + half, times[-1]), AVERAGED, axis=1)
    return np.where(r.by_markers[:, None, None], 0.0, r.shape.covariance(averaged))


def by_readings(r: Recording, model: Model, times: Floats, known: Floats) -> Floats:
    """SD (B - 1, 3) [m, m, rad] of windows between times (B,) [s], about each of which poses are averaged; known: what
    of shapes there is noise, see `of_shapes`."""
    if not known.any():
        return np.zeros((len(times) - 1, 3))
    off = by_bends(r, model, times)
    own = np.einsum("bjc,jbb->bc", off**2, known)
    both = np.einsum("bjc,bjc,jb->bc", off[:-1], off[1:], np.diagonal(known, 1, axis1=1, axis2=2))
    return np.asarray(np.sqrt(np.maximum(own[:-1] + own[1:] - 2 * both, 0.0)))


def by_bends(r: Recording, model: Model, times: Floats) -> Floats:
    """G - A of every joint (B, m, 3) [m/rad, m/rad, 1], by steps of drag alone."""
    joints, length = r.body.joint_count, r.body.total_length_m
    angles = r.angles_at(times)
    plain = shapes(r.body, angles)
    each = np.repeat(angles, joints, axis=0) + np.tile(BENT * np.eye(joints), (len(times), 1))
    bent, before = shapes(r.body, each), np.repeat(plain, joints, axis=0)
    seen = register(bent, before)[0]
    drag = Model(r.body, model.medium.model_copy(update={"law": VISCOUS.name}))
    rows = [elements_of_vertices(drag, chain / length) for chain in (before, bent)]
    pushed = solve_steps(drag, *rows).relative * r.body.pose_units
    return np.asarray((seen - pushed).reshape(len(times), joints, 3) / BENT)
