"""Joint limits on the whole table with a few constraint rows: an exchange method.

Every joint angle is a smooth wave over the T rows, so limits at K well chosen rows imply the others. The NLP carries K
rows whose phases are parameters; after a solve all T rows are checked, and the worst violated ones take the place of
idle ones (K grows where that is not enough). The final answer satisfies every row.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.base import ActuationEffect
from serpenoid.problem import Problem

FIRST_ROWS = 10
TOLERANCE = 1e-9


@dataclass(frozen=True)
class PathLimits:
    """Bounds on a row's joint angles and their change to the next row, shape (2 m,); infinite where switched off."""

    upper: Floats

    @property
    def any(self) -> bool:
        """Whether anything is limited."""
        return bool(np.isfinite(self.upper).any())


def path_limits(problem: Problem) -> PathLimits:
    """The limits that hold; the change per step follows from speed limit and cycle duration, where both are known."""
    task, m = problem.task, problem.body.joint_count
    upper = np.full(2 * m, np.inf)
    if problem.joint_limit_deg is not None:
        upper[:m] = np.deg2rad(problem.joint_limit_deg)
    if problem.joint_speed_limit_rpm is not None and task.cycle_duration_s is not None:
        speed = problem.joint_speed_limit_rpm * 2 * np.pi / 60
        upper[m:] = speed * task.cycle_duration_s / task.steps
    for active in problem.model.actuation_effects:
        if isinstance(active.effect, ActuationEffect):  # a gait that never saturates is played as it is commanded
            reach = active.effect.speed_limit(active.parameters) * problem.model.step_duration(task.steps)
            upper[m:] = np.minimum(upper[m:], reach)
    return PathLimits(upper)


def violations(table: Floats, limits: PathLimits, closed: bool = True) -> Floats:
    """How far each row of a table (..., R, m) exceeds the limits, shape (..., R, 2 m); negative where it does not.

    Not closed: the last row stays.
    """
    change = np.roll(table, -1, axis=-2) - table
    if not closed:
        change[..., -1, :] = 0.0
    return np.abs(np.concatenate([table, change], -1)) - limits.upper


def worst_violation(table: Floats, limits: PathLimits) -> Floats:
    """Largest violation of each table, shape (...,)."""
    if not limits.any:
        return np.full(table.shape[:-2], -np.inf)
    return violations(table, limits).max(axis=(-2, -1))


def even_rows(steps: int, count: int) -> list[int]:
    """`count` different rows spread evenly over the table."""
    return sorted({int(i * steps / count) for i in range(count)})


def exchange(rows: list[int], table: Floats, limits: PathLimits, steps: int) -> list[int]:
    """New rows for the NLP: those that bind, those worst violated; filled up evenly, more of them if need be."""
    excess = violations(table, limits)
    worst = {int(excess[:, j].argmax()) for j in range(excess.shape[1]) if excess[:, j].max() > TOLERANCE}
    binding = {row for row in rows if excess[row].max() > -1e-4}
    wanted = worst | binding
    count = len(rows)
    while count < min(len(wanted), steps):
        count = min(2 * count, steps)
    if wanted <= set(rows):
        count = min(2 * count, steps)
    free = [row for row in even_rows(steps, min(2 * count, steps)) if row not in wanted]
    free += [row for row in range(steps) if row not in wanted and row not in free]
    return sorted(wanted | set(free[: count - len(wanted)]))
