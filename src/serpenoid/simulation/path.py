"""How a whole simulated path depends on every parameter and on its first pose: for fits of paths.

All steps' residuals together, r(g_1 .. g_S; g_0, theta) = 0, have a banded derivative by the poses (see `chain`), so
d g / d theta is one banded solve with a right side per parameter. Legend: R rows, S = R - 1 steps, P columns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.active import ActiveEffect
from serpenoid.model import Model
from serpenoid.simulation.chain import Chain, evaluate_window
from serpenoid.simulation.newton import implicit_derivative
from serpenoid.simulation.rollout import simulate_vertices
from serpenoid.simulation.sensitivity import Column, MeasuredSteps, recorded
from serpenoid.status import Status
from serpenoid.trajectory import Trajectory


@dataclass(frozen=True)
class PathSensitivities:
    """A simulated path, poses (R, 3) in `trajectory`, with its derivatives.

    by_start (R, 3, 3): by the first pose (the last of several first poses); jacobian (R, 3, P): by the columns'
    coordinates (eps first). NaN where the simulation failed.
    """

    trajectory: Trajectory
    by_start: Floats
    jacobian: Floats
    columns: tuple[Column, ...]


def path_sensitivities(
    model: Model,
    vertices: Floats,
    times: Floats,
    start: Floats | None = None,
    candidates: Sequence[ActiveEffect] = (),
    near: Floats | None = None,
) -> PathSensitivities:
    """Simulate shapes (R, N, 2) [body lengths] from pose `start`, with exact derivatives of every pose.

    Arguments as for `simulate_vertices` and `step_sensitivities`; `start` (K + 1, 3): first poses of a body that is
    moving already, which no parameter changes. `near`: see `solve_extended`.
    """
    motion = simulate_vertices(model, vertices, start, times, near)
    problem, columns = recorded(
        model, MeasuredSteps.of(model, vertices, np.asarray(times, float), motion.poses), candidates
    )
    rows, count = len(motion.poses), len(columns)
    if motion.status is not Status.SOLVED:
        return PathSensitivities(motion, np.full((rows, 3, 3), np.nan), np.full((rows, 3, count), np.nan), columns)
    chain = Chain(problem.law, *problem.elements_by_step, problem.settings, problem.steps.inertia)
    now = evaluate_window(chain, slice(0, rows - 1), motion.poses, np.zeros((2, 3)))
    given = 0 if start is None else len(np.atleast_2d(start)) - 1
    residual_by = np.zeros((rows - 1, 3, 3 + count))
    for age in range(1, min(4, rows - given)):  # the pose begun with is in the residuals of three steps
        residual_by[given + age - 1, :, :3] = now.slopes[age, given + age - 1]
    residual_by[:, :, 3:] = problem.residual_derivatives(columns)
    first = np.zeros((given + 1, 3, 3 + count))
    first[-1, :, :3] = np.eye(3)
    by = np.concatenate([first, implicit_derivative(now.slopes[:, given:], residual_by[given:])])
    return PathSensitivities(motion, by[..., :3], by[..., 3:], columns)
