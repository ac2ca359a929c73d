"""Joint limits on the whole table with a few constraint rows: an exchange method.

Every joint angle is a smooth wave over the T rows, so limits at K well chosen rows imply the others. The NLP carries K
rows whose phases are parameters; after a solve all T rows are checked, and the worst violated ones take the place of
idle ones. A row that once bound or was violated stays, or the same rows would come and go for ever; K doubles where
those that stay need it. The final answer satisfies every row.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.base import ActuationEffect
from serpenoid.joint_range import ranges_deg
from serpenoid.problem import Problem

FIRST_ROWS = 10  # beside other numbers in results/benchmarks/approach.md (benchmarks/approach.py)
TOLERANCE = 1e-9
BINDING = -1e-4  # rad: as near to its limit as this, a row is held by it


@dataclass(frozen=True)
class PathLimits:
    """Bounds on a row's joint angles and their change to the next row, shape (2 m,); infinite where switched off."""

    lower: Floats
    upper: Floats

    @property
    def any(self) -> bool:
        """Whether anything is limited."""
        return bool(np.isfinite(self.upper).any())

    @property
    def even(self) -> bool:
        """Whether every range is the same to either side."""
        return bool((self.lower == -self.upper).all())

    def of_rows(self, count: int) -> tuple[Floats, Floats]:
        """Lower and upper bounds of so many rows, one after the other, shape (count 2 m,)."""
        return np.tile(self.lower, count), np.tile(self.upper, count)


def path_limits(problem: Problem) -> PathLimits:
    """The limits that hold; the change per step follows from speed limit and cycle duration, where both are known."""
    task, m = problem.task, problem.family_of().joints
    upper = np.full(2 * m, np.inf)
    lower = -upper
    if problem.joint_limit_deg is not None:
        lower[:m], upper[:m] = np.deg2rad(ranges_deg(problem.joint_limit_deg, m)).T
    if problem.joint_speed_limit_rpm is not None and task.cycle_duration_s is not None:
        speed = problem.joint_speed_limit_rpm * 2 * np.pi / 60
        upper[m:] = speed * task.cycle_duration_s / task.steps
    for active in problem.model.actuation_effects:
        if isinstance(active.effect, ActuationEffect):  # a gait that never saturates is played as it is commanded
            reach = active.effect.speed_limit(active.parameters) * problem.model.step_duration(task.steps)
            own = slice(m, None) if active.place is None else m + active.place - 1
            upper[own] = np.minimum(upper[own], reach)
    lower[m:] = -upper[m:]
    return PathLimits(lower, upper)


def violations(table: Floats, limits: PathLimits, closed: bool = True) -> Floats:
    """How far each row of a table (..., R, m) exceeds the limits, shape (..., R, 2 m); negative where it does not.

    Not closed: the last row stays.
    """
    change = np.roll(table, -1, axis=-2) - table
    if not closed:
        change[..., -1, :] = 0.0
    both = np.concatenate([table, change], -1)
    return np.maximum(both - limits.upper, limits.lower - both)


def even_rows(steps: int, count: int) -> list[int]:
    """`count` different rows spread evenly over the table."""
    return sorted({int(i * steps / count) for i in range(count)})


def exchange(rows: Sequence[int], staying: Set[int], excess: Floats) -> tuple[list[int], Set[int]]:
    """New rows for the NLP, and those of them that stay: all that ever bound or were violated. The rest lies evenly.

    excess: violations of all rows (R, 2 m) with what was found.
    """
    steps = len(excess)
    worst = {int(excess[:, j].argmax()) for j in range(excess.shape[1]) if excess[:, j].max() > TOLERANCE}
    staying = frozenset(staying | worst | {row for row in rows if excess[row].max() > BINDING})
    count = len(rows) if worst - set(rows) else 2 * len(rows)
    while count < len(staying):
        count *= 2
    count = min(count, steps)
    free = [row for row in even_rows(steps, min(2 * count, steps)) if row not in staying]
    free += [row for row in range(steps) if row not in staying and row not in free]
    return sorted(staying | set(free[: count - len(staying)])), staying
