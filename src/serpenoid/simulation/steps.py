"""All steps of a sequence of shapes at once: shapes fix the relative poses, which need no order.

A step's root is checked: residual, curvature (a minimum of the energy) and turn. Where Newton's method from "no turn"
fails a check, every minimum over a full turn is bracketed, and the one with the least turn is taken.

Legend: S steps, M elements, N vertices, m joints.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np
from scipy.optimize import brentq

from serpenoid.body import Floats
from serpenoid.mechanics import columns, functions, planar
from serpenoid.mechanics.evaluate import evaluate
from serpenoid.model import Model, Structure
from serpenoid.simulation.newton import at_root

SUSPICIOUS_TURN = 0.35  # rad; a step of a resolved gait turns far less
CHUNK = 1600  # rows whose elements stay in the second cache
SAMPLES = 720  # half a degree: the energy has two harmonics, so its minima are far wider apart


@dataclass(frozen=True)
class Steps:
    """Relative poses (S, 3), energies (S,), residuals (S,) and a flag per step that its root is sound."""

    relative: Floats
    energy: Floats
    residual: Floats
    sound: np.ndarray


def solve_steps(model: Model, before: Floats, after: Floats) -> Steps:
    """Place `after` against `before`, element arrays of shape (4, M S), for S independent steps."""
    pose, residual, curvature, energy = columns.steps(model.structure)(before.T, after.T, model.parameters)
    sound = _sound(pose, residual, curvature)
    relative, residual, energy = pose.T, np.abs(residual[0]), energy[0]
    for s in np.flatnonzero(~sound):
        found = _search(model, before, after, int(s))
        if found is not None:
            relative[s], residual[s], energy[s], stiffness = found
            sound[s] = bool(at_root(residual[[s]], np.array([[[stiffness]]]))[0])
    return Steps(relative, energy, residual, sound)


def elements_of_vertices(model: Model, vertices: Floats) -> Floats:
    """Dissipation elements of chains (R, N, 2): shape (4, M R)."""
    return evaluate(_vertices_to_elements(model.structure, len(vertices)), vertices)[0]


def shape_rows(model: Model, joint_angles: Floats) -> tuple[Floats, Floats]:
    """Vertices (R, N, 2) in the body frame and elements (4, M R) of joint angles (R, m)."""
    rows = joint_angles.shape[0]
    points, found = columns.shapes(model.structure)(joint_angles, model.parameters)
    return points.T.reshape(rows, -1, 2), found


@lru_cache(maxsize=128)
def _vertices_to_elements(structure: Structure, rows: int) -> ca.Function:
    return functions.shape_elements(structure).map(rows)


def _search(model: Model, before: Floats, after: Floats, s: int) -> tuple[Floats, float, float, float] | None:
    m = model.structure.elements
    part = slice(m * s, m * (s + 1))
    moments = functions.step_moments(model.structure)(before[:, part], after[:, part], model.parameters)
    if not np.isfinite(moments.full()).all():
        return None
    reduced = planar.step_at()
    turns = np.linspace(-np.pi, np.pi, SAMPLES + 1)
    slope = reduced.map(turns.size)(turns[None, :], ca.repmat(moments, 1, turns.size))[1].full()[0]
    minima = np.flatnonzero((slope[:-1] < 0) & (slope[1:] >= 0))
    roots = [brentq(lambda x: float(reduced(x, moments)[1]), turns[i], turns[i + 1], xtol=1e-16) for i in minima]
    if not roots:
        return None
    phi = min(roots, key=abs)
    b, residual, stiffness, energy = reduced(phi, moments)
    return np.array([*b.full()[:, 0], phi]), abs(float(residual)), float(energy), float(stiffness)


def solve_cycles(model: Model, tables: Floats) -> Steps:
    """Steps of B closed joint tables (B, T, m); S = B T.

    Steps whose root is not sound are left marked; `solve_steps` repairs them.
    """
    count = max(1, CHUNK // tables.shape[1])
    parts = [_cycles(model, tables[first : first + count]) for first in range(0, len(tables), count)]
    pose, residual, curvature, energy = (np.concatenate(part, axis=1) for part in zip(*parts, strict=True))
    return Steps(pose.T, energy[0], np.abs(residual[0]), _sound(pose, residual, curvature))


def _cycles(model: Model, tables: Floats) -> list[Floats]:
    b, t, joints = tables.shape
    _, elements = columns.shapes(model.structure)(tables.reshape(b * t, joints), model.parameters)
    before = elements.T.reshape(b, t, -1)
    after = np.concatenate([before[:, 1:], before[:, :1]], axis=1)
    return columns.steps(model.structure)(before.reshape(-1, 4), after.reshape(-1, 4), model.parameters)


def _sound(pose: Floats, residual: Floats, curvature: Floats) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        found = at_root(np.abs(residual[0]), curvature[0][:, None, None])
        return np.asarray(found & (curvature[0] > 0) & (np.abs(pose[2]) <= SUSPICIOUS_TURN))
