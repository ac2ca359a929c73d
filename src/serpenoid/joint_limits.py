"""The limits that a body declares, said beside every gait: kept, broken, or switched off.

T: steps, m: joints; a joint table has T rows where it is closed, and T + 1 where it is a transient.
"""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Floats

if TYPE_CHECKING:
    from serpenoid.problem import Problem

KEPT = 1e-6  # relative: beyond the optimiser's own tolerance, far below a servo's step


def largest_angle(table: Floats) -> tuple[int, float]:
    """Joint (0 next to the tail) and largest |angle| [degrees] of a table [rad]."""
    reach = np.degrees(np.abs(table)).max(axis=0)
    return int(reach.argmax()), float(reach.max())


def travels(table: NDArray[Any], closed: bool) -> NDArray[Any]:
    """How far each step of a table leads, (T, m), in the table's unit; in a closed one the last leads to the first."""
    return np.abs(np.diff(table, axis=0, append=table[:1] if closed else table[:0]))


def turns_per_cycle(table: Floats, closed: bool) -> tuple[int, float]:
    """Joint and its fastest step of a table [rad], in turns per cycle: times 60 / seconds it is rpm."""
    steps = travels(table, closed)
    fastest = steps.max(axis=0) * len(steps) / (2 * np.pi)
    return int(fastest.argmax()), float(fastest.max())


def limit_lines(problem: Problem, table: Floats) -> list[str]:
    """Lines for a summary; none for a body that declares no limits."""
    return [*_angle_lines(problem, table), *_speed_lines(problem, table)]


def _angle_lines(problem: Problem, table: Floats) -> list[str]:
    declared = problem.body.joint_limit_deg
    if declared is None:
        return []
    joint, reach = largest_angle(table)
    if problem.joint_limit_deg is None:
        return [f"joint limit       {declared:g} degrees SWITCHED OFF by `joint_limits`; joints reach {reach:.1f}"]
    if reach > declared * (1 + KEPT):
        return [f"warning           joint_{joint + 1} reaches {reach:.1f} degrees, its limit is {declared:g}"]
    return [f"joint limit       {declared:g} degrees; joints reach {reach:.1f}"]


def _speed_lines(problem: Problem, table: Floats) -> list[str]:
    declared, duration = problem.body.joint_speed_limit_rpm, problem.task.cycle_duration_s
    if declared is None:
        return []
    joint, turns = turns_per_cycle(table, closed=not problem.task.transient)
    shortest = ceil(turns * 60 / declared * 100) / 100
    if duration is None:
        return [
            f"warning           joint_speed_limit_rpm = {declared:g} does not hold without `cycle_duration_s`; this "
            f"gait keeps to it in cycles of {shortest:g} s or more"
        ]
    speed = turns * 60 / duration
    if problem.joint_speed_limit_rpm is None:
        return [f"joint speed       {declared:g} rpm SWITCHED OFF by `joint_speed_limits`; joints reach {speed:.1f}"]
    if speed > declared * (1 + KEPT):
        return [f"warning           joint_{joint + 1} turns at {speed:.1f} rpm, its limit is {declared:g}"]
    return [f"joint speed       {declared:g} rpm; joints reach {speed:.1f}"]
