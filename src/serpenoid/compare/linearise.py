"""The step equations and their derivatives at measured shapes and poses, on the recording's own time grid.

The modelled relative pose xi of a step from shape alpha to alpha' is the root of mu(alpha, alpha', xi; theta) = 0. The
defect is measured minus modelled,  e = g^-1 g' - xi,  and by the implicit function theorem, with J = d mu / d xi,
de = d(g^-1 g') + J^-1 (mu_alpha d alpha + mu_alpha' d alpha' + mu_theta d theta): exact, however large e is.
One step from frame to frame misses what goes with the square of its duration (0.2 % of eps at 75 frames a cycle): xi is
extrapolated from steps on splines through the shapes; its derivatives are those of the one step.
A pose is that of a point of the body: the centroid by weights that are the recording's, whatever the model weighs.

Legend: S steps, N vertices, m joints, P parameters.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np
from scipy.interpolate import CubicSpline

from serpenoid import group
from serpenoid.body import Floats
from serpenoid.body_curve import SMOOTH
from serpenoid.mechanics import functions
from serpenoid.mechanics.compile import compiled
from serpenoid.model import Model, Structure
from serpenoid.simulation import simulate_joint_angles
from serpenoid.simulation.curve import amid_edges, simulate_curve
from serpenoid.simulation.newton import implicit_derivative

FINER = 2  # steps between two rows, from which one without error is extrapolated
FEWEST = 4  # rows that say how a shape runs between them


@dataclass(frozen=True)
class Linearised:
    """Per step: defect (S, 3) and its derivatives, all in units of relative motion (forward, left, turn)."""

    defect: Floats  # (S, 3) without error of the mesh; of an animal by the curve through its points
    by_before: Floats  # (S, 3, 3 + m): pose and joint angles before the step
    by_after: Floats  # (S, 3, 3 + m)
    by_parameters: Floats  # (S, 3, 2 N): edges, weights, anisotropy ratio


@lru_cache(maxsize=16)
def step_derivatives(structure: Structure) -> ca.Function:
    """(angles (m), angles_after (m), relative pose (3), parameters (2 N), weights (N) of the centroid whose pose it is)
    -> the four Jacobians of the momentum."""
    m, n = len(structure.joints), structure.vertices
    before, after = ca.SX.sym("angles", m), ca.SX.sym("angles_after", m)
    pose, parameters, about = ca.SX.sym("pose", 3), ca.SX.sym("parameters", 2 * n), ca.SX.sym("about", n)
    mu = _momentum(structure, before, after, pose, parameters, about)
    inputs = [before, after, pose, parameters, about]
    outputs = [ca.densify(ca.jacobian(mu, x)) for x in (pose, before, after, parameters)]
    names = ["by_pose", "by_angles", "by_angles_after", "by_parameters"]
    said = ["angles", "angles_after", "pose", "parameters", "about"]
    return ca.Function("step_derivatives", inputs, outputs, said, names, {"cse": True})


def _momentum(structure: Structure, before: ca.SX, after: ca.SX, pose: ca.SX, parameters: ca.SX, about: ca.SX) -> ca.SX:
    shape, elements = functions.shape(structure), []
    for angles in (before, after):
        points, own = shape(angles, parameters)
        elements.append(ca.vertcat(own[:2, :] - points @ about, own[2:, :]))
    return functions.step_momentum(structure)(*elements, pose, parameters)


def about_centroid(poses: Floats, vertices: Floats, weights: Floats) -> Floats:
    """Poses (R, 3) of chains (R, N, 2) with the place of their centroid by weights (N,), sum 1."""
    return np.column_stack([np.einsum("rni,n->ri", vertices, weights), poses[:, 2]])


def relative_poses(poses: Floats) -> Floats:
    """Each pose in the frame of the one before, shape (R, 3) -> (R - 1, 3)."""
    return group.relative(poses[:-1], poses[1:])


def linearise(
    model: Model, joint_angles: Floats, poses: Floats, weights: Floats | None = None, degree: int = SMOOTH
) -> Linearised:
    """Defects of the steps between successive rows of joint angles (R, m) and poses (R, 3) [body lengths].

    weights (N,), sum 1: of the centroid whose poses these are; default the model's.
    """
    weights = model.body.vertex_weights if weights is None else weights
    model = amid_edges(model) if model.body.is_animal else model  # nearer to what drag along its curve does
    steps = len(poses) - 1
    relative = relative_poses(poses)
    motion = simulate_joint_angles(model, joint_angles, closed=False)
    modelled = relative_poses(about_centroid(motion.poses, motion.vertices, weights))
    alike = (np.tile(column[:, None], steps) for column in (model.parameters, weights))
    inputs = (joint_angles[:-1].T, joint_angles[1:].T, modelled.T, *alike)
    results = _mapped(model.structure, steps)(*inputs)
    by_pose, by_angles, by_after, by_parameters = (_stack(result, steps) for result in results)
    widths = np.cumsum([by_angles.shape[2], by_after.shape[2]])
    root_by = implicit_derivative(by_pose[None], np.concatenate([by_angles, by_after, by_parameters], axis=2))
    before, after, parameters = np.split(root_by, widths, axis=2)
    pose_before, pose_after = _relative_derivatives(poses, relative)
    if model.body.is_animal:
        curve = simulate_curve(model, motion.vertices, degree=degree)
        modelled = relative_poses(about_centroid(curve.poses, curve.vertices, weights))
    else:
        modelled = modelled + mesh_error(model, joint_angles, modelled, weights)
    return Linearised(
        relative - modelled,
        np.concatenate([pose_before, -before], axis=2),
        np.concatenate([pose_after, -after], axis=2),
        -parameters,
    )


def mesh_error(model: Model, joint_angles: Floats, modelled: Floats, weights: Floats) -> Floats:
    """What single steps (S, 3) between rows of joint angles (S + 1, m) miss of the motion between these rows (S, 3)."""
    if len(joint_angles) < FEWEST:
        return np.zeros_like(modelled)
    rows = np.arange(len(joint_angles))
    between = CubicSpline(rows, joint_angles)(np.arange(FINER * len(modelled) + 1) / FINER)
    motion = simulate_joint_angles(model, between, closed=False)
    finer = relative_poses(about_centroid(motion.poses[::FINER], motion.vertices[::FINER], weights))
    return np.asarray((finer - modelled) * FINER**2 / (FINER**2 - 1))


@lru_cache(maxsize=64)
def _mapped(structure: Structure, steps: int) -> ca.Function:
    return _compiled(structure).map(steps)


@lru_cache(maxsize=16)
def _compiled(structure: Structure) -> ca.Function:
    return compiled([step_derivatives(structure)])[0]


def _stack(result: ca.DM, steps: int) -> Floats:
    """(3, S k) columns to (S, 3, k)."""
    full = np.asarray(result.full())
    return full.reshape(full.shape[0], steps, -1).transpose(1, 0, 2)


def _relative_derivatives(poses: Floats, relative: Floats) -> tuple[Floats, Floats]:
    """Derivatives of the relative pose by the pose before and the pose after, each (S, 3, 3)."""
    turn_back = np.zeros((len(relative), 3, 3))
    turn_back[:, :2, :2] = np.swapaxes(group.rotation(poses[:-1, 2]), 1, 2)
    turn_back[:, 2, 2] = 1.0
    before = -turn_back
    before[:, 0, 2], before[:, 1, 2] = relative[:, 1], -relative[:, 0]
    return before, turn_back
