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
from serpenoid.mechanics import functions
from serpenoid.mechanics.compile import compiled
from serpenoid.mechanics.evaluate import evaluate
from serpenoid.model import Model, Structure

TOLERANCE = 1e-12
SUSPICIOUS_TURN = 0.35  # rad; a step of a resolved gait turns far less
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
    structure = model.structure
    count = before.shape[1] // structure.elements
    _, step = _compiled(structure)
    mapped = _mapped(step, count)
    guess = np.zeros(1)
    pose, residual, curvature, energy = evaluate(mapped, before.T, after.T, guess, model.parameters)
    sound = _sound(pose, residual, curvature)
    relative, residual, energy = pose.T, np.abs(residual[0]), energy[0]
    for s in np.flatnonzero(~sound):
        found = _search(model, before, after, int(s))
        if found is not None:
            relative[s], residual[s], energy[s] = found
            sound[s] = residual[s] <= TOLERANCE
    return Steps(relative, energy, residual, sound)


def elements_of_vertices(model: Model, vertices: Floats) -> Floats:
    """Dissipation elements of chains (R, N, 2): shape (4, M R)."""
    rows = vertices.shape[0]
    points = np.ascontiguousarray(vertices).reshape(rows * vertices.shape[1], 2).T
    function = functions.shape_elements(model.structure)
    return _mapped(function, rows)(points).full()


def shape_rows(model: Model, joint_angles: Floats) -> tuple[Floats, Floats]:
    """Vertices (R, N, 2) in the body frame and elements (4, M R) of joint angles (R, m)."""
    shapes, _ = _compiled(model.structure)
    rows = joint_angles.shape[0]
    points, found = evaluate(_mapped(shapes, rows), joint_angles, model.parameters)
    return points.T.reshape(rows, -1, 2), found


@lru_cache(maxsize=32)
def _compiled(structure: Structure) -> tuple[ca.Function, ca.Function]:
    shapes, step = compiled([functions.shape(structure), functions.step(structure)])
    return shapes, step


@lru_cache(maxsize=128)
def _mapped(function: ca.Function, count: int) -> ca.Function:
    """`function` over `count` columns; the last input (parameters), if there are several inputs, is shared."""
    if function.n_in() == 1:
        return function.map(count)
    shared = [function.n_in() - 1] if function.n_in() == 2 else [function.n_in() - 2, function.n_in() - 1]
    return function.map(f"map{count}_{function.name()}", "serial", count, shared, [])


def _search(model: Model, before: Floats, after: Floats, s: int) -> tuple[Floats, float, float] | None:
    m = model.structure.elements
    part = slice(m * s, m * (s + 1))
    moments = functions.step_moments(model.structure)(before[:, part], after[:, part], model.parameters)
    if not np.isfinite(moments.full()).all():
        return None
    reduced = functions.reduced_step()
    turns = np.linspace(-np.pi, np.pi, SAMPLES + 1)
    slope = reduced.map(turns.size)(turns[None, :], ca.repmat(moments, 1, turns.size))[1].full()[0]
    minima = np.flatnonzero((slope[:-1] < 0) & (slope[1:] >= 0))
    roots = [brentq(lambda x: float(reduced(x, moments)[1]), turns[i], turns[i + 1], xtol=1e-16) for i in minima]
    if not roots:
        return None
    phi = min(roots, key=abs)
    b, residual, _, energy = reduced(phi, moments)
    return np.array([*b.full()[:, 0], phi]), abs(float(residual)), float(energy)


def solve_cycles(model: Model, tables: Floats) -> Steps:
    """Steps of B closed joint tables (B, T, m) without leaving compiled code between shapes and roots; S = B T.

    Steps whose root is not sound are left marked; `solve_steps` repairs them.
    """
    b, t, _ = tables.shape
    pose, residual, curvature, energy = evaluate(_cycles(model.structure, t, b), tables, model.parameters)
    return Steps(pose.T, energy[0], np.abs(residual[0]), _sound(pose, residual, curvature))


def _sound(pose: Floats, residual: Floats, curvature: Floats) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        return (np.abs(residual[0]) <= TOLERANCE) & (curvature[0] > 0) & (np.abs(pose[2]) <= SUSPICIOUS_TURN)


@lru_cache(maxsize=32)
def _cycles(structure: Structure, steps: int, count: int) -> ca.Function:
    shapes, step = _compiled(structure)
    m = structure.elements
    angles = ca.MX.sym("angles", len(structure.joints), steps)
    parameters = ca.MX.sym("parameters", 2 * structure.vertices)
    _, before = _mapped(shapes, steps)(angles, parameters)
    after = ca.horzcat(before[:, m:], before[:, :m])
    cycle = ca.Function("cycle", [angles, parameters], _mapped(step, steps)(before, after, 0, parameters))
    return cycle.map("cycles", "serial", count, [1], [])
