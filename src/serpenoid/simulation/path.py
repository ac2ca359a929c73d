"""How whole simulated paths depend on every parameter and on their first poses: for fits of paths.

All steps' residuals together, r(g_1 .. g_S; g_0, theta) = 0, have a banded derivative by the poses (see `chain`), so
d g / d theta is one forward substitution with a right side per parameter. Paths that do not know each other are found
side by side. Legend: R rows, S = R - 1 steps of a path, n steps of all of them, P columns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from serpenoid import group
from serpenoid.body import Floats
from serpenoid.effects.active import ActiveEffect
from serpenoid.model import Model
from serpenoid.simulation.chain import AGES, Chain, coupled, solve_chains
from serpenoid.simulation.extended import in_order, solve_extended
from serpenoid.simulation.law import MediumNumbers
from serpenoid.simulation.newton import implicit_derivative
from serpenoid.simulation.sensitivity import Column, MeasuredSteps, recorded
from serpenoid.simulation.steps import Steps, solve_steps


@dataclass(frozen=True)
class PathSensitivities:
    """A simulated path, poses (R, 3), with its derivatives.

    by_start (R, 3, 3): by the first pose (the last of several first poses); jacobian (R, 3, P): by the columns'
    coordinates (eps first). NaN where the simulation failed.
    """

    poses: Floats
    by_start: Floats
    jacobian: Floats
    columns: tuple[Column, ...]


def path_sensitivities(
    model: Model,
    vertices: Floats,
    times: Floats,
    start: Floats | None = None,
    candidates: Sequence[ActiveEffect] = (),
) -> PathSensitivities:
    """Simulate shapes (R, N, 2) [body lengths] from pose `start`, with exact derivatives of every pose.

    Arguments as for `simulate_vertices` and `step_sensitivities`; `start` (K + 1, 3): first poses of a body that is
    moving already, which no parameter changes.
    """
    steps = MeasuredSteps.of(model, vertices, np.asarray(times, float), np.zeros((len(vertices), 3)))
    return paths_of(model, [steps], [np.zeros(3) if start is None else start], candidates)[0]


def paths_of(
    model: Model,
    motions: Sequence[MeasuredSteps],
    starts: Sequence[Floats],
    candidates: Sequence[ActiveEffect] = (),
    near: Sequence[Floats] | None = None,
) -> list[PathSensitivities]:
    """The same of several motions, from the first poses of each; the poses that were measured are not asked.

    near: relative poses (S, 3) of a model much like this one, where the search begins if steps need those before.
    """
    known = [np.atleast_2d(s) for s in starts]
    found = _roots(model, motions, known, near)
    poses = [group.accumulate(f.relative, k[0]) for f, k in zip(found, known, strict=True)]
    given = np.array([len(k) - 1 for k in known])
    columns, derivatives = _derivatives(model, motions, [np.nan_to_num(p) for p in poses], given, candidates)
    for by, steps in zip(derivatives, found, strict=True):
        by[:] = by if steps.sound.all() else np.nan
    return [PathSensitivities(p, b[..., :3], b[..., 3:], columns) for p, b in zip(poses, derivatives, strict=True)]


def _roots(
    model: Model, motions: Sequence[MeasuredSteps], starts: Sequence[Floats], near: Sequence[Floats] | None
) -> list[Steps]:
    """Relative poses of each; where the search from near does not find them, from the baseline's."""
    if near is None or not in_order(model):
        return [_root(model, m, s) for m, s in zip(motions, starts, strict=True)]
    law = MediumNumbers.of(model)
    chains = [Chain.of(law, m.before, m.after, m.spans, m.inertia) for m in motions]
    found = solve_chains(model, chains, starts, near)
    return [f if f.sound.all() else _root(model, m, s) for f, m, s in zip(found, motions, starts, strict=True)]


def _root(model: Model, motion: MeasuredSteps, start: Floats) -> Steps:
    if model.is_plain:
        return solve_steps(model, motion.before, motion.after)
    elements = np.hstack([motion.before, motion.after[:, -model.structure.elements :]])
    return solve_extended(model, elements, np.append(motion.spans[:, 0], motion.spans[-1, 1]), start)


def _derivatives(
    model: Model,
    motions: Sequence[MeasuredSteps],
    poses: Sequence[Floats],
    given: np.ndarray,
    candidates: Sequence[ActiveEffect],
) -> tuple[tuple[Column, ...], list[Floats]]:
    """Columns; derivatives (R, 3, 3 + P) of each motion's poses: by the first that is not `given`, by the columns."""
    steps = MeasuredSteps.joined([replace(m, starts=p[:-1], ends=p[1:]) for m, p in zip(motions, poses, strict=True)])
    problem, columns = recorded(model, steps, candidates)
    lengths = np.array([len(m) for m in motions])
    chain = Chain.of(problem.law, steps.before, steps.after, steps.spans, steps.inertia)
    first, rest = np.array([p[0] for p in poses]), np.zeros((len(poses), 2, 3))
    now = coupled(problem.law, chain, lengths, first, rest, steps.ends)
    place = np.arange(len(steps)) - np.repeat(np.cumsum(lengths) - lengths + given, lengths)
    by = np.zeros((len(steps), 3, 3 + len(columns)))
    for age in range(1, AGES):  # the pose begun with is in the residuals of three steps
        by[place == age - 1, :, :3] = now.slopes[age, place == age - 1]
    by[:, :, 3:] = problem.residual_derivatives(columns)
    free, own = place >= 0, lengths - given
    found = implicit_derivative(now.slopes[:, free], by[free], own)
    parts = np.split(found, np.cumsum(own)[:-1])
    begun = np.concatenate([np.eye(3), np.zeros((3, len(columns)))], axis=1)
    return columns, [
        np.concatenate([np.zeros((g, 3, 3 + len(columns))), begun[None], p]) for g, p in zip(given, parts, strict=True)
    ]
