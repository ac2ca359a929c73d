"""The limits that a body declares, said beside every gait: kept, broken, or switched off.

T: steps, m: joints; a joint table has T rows where it is closed, and T + 1 where it is a transient.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Floats
from serpenoid.joint_range import Limit, limit_words, range_words, ranges_deg
from serpenoid.table_file import header

if TYPE_CHECKING:
    from serpenoid.problem import Problem

WARNING = "warning"  # begins the line
LONG = 1e6  # degrees: more digits tell nothing
KEPT = 1e-6  # relative: beyond the optimiser's own tolerance, far below a servo's step


def largest_angle(table: Floats) -> tuple[int, float]:
    """Joint (0 next to the tail) and largest |angle| [degrees] of a table [rad]."""
    reach = np.degrees(np.abs(table)).max(axis=0)
    return int(reach.argmax()), float(reach.max())


@dataclass(frozen=True)
class Farthest:
    """Where a table goes farthest beyond the range of a joint, or comes nearest to its end.

    joint: 0 next to the tail; step: the row; angle, lower, upper [degrees].
    """

    joint: int
    step: int
    angle: float
    lower: float
    upper: float

    @property
    def kept(self) -> bool:
        """Whether the range is kept, to rounding."""
        slack = KEPT * max(abs(self.lower), abs(self.upper))
        return self.lower - slack <= self.angle <= self.upper + slack

    @property
    def reach(self) -> float:
        """The angle as people compare it with the range: without its sign where that does not matter [degrees]."""
        return abs(self.angle) if self.lower == -self.upper else self.angle

    @property
    def limit(self) -> str:
        """The joint's range in words."""
        return range_words(self.lower, self.upper)


def farthest(table: Floats, limit: Limit) -> Farthest:
    """Where a table (T, m) [rad] goes farthest beyond a limit [degrees]."""
    angles, ranges = np.degrees(table), ranges_deg(limit, table.shape[1])
    beyond = np.maximum(angles - ranges[:, 1], ranges[:, 0] - angles)
    step, joint = (int(i) for i in np.unravel_index(beyond.argmax(), beyond.shape))
    return Farthest(joint, step, float(angles[step, joint]), *ranges[joint].tolist())


def travels(table: NDArray[Any], closed: bool) -> NDArray[Any]:
    """How far each step of a table leads, (T, m), in the table's unit; in a closed one the last leads to the first."""
    return np.abs(np.diff(table, axis=0, append=table[:1] if closed else table[:0]))


def turns_per_cycle(table: Floats, closed: bool) -> tuple[int, float]:
    """Joint and its fastest step of a table [rad], in turns per cycle: times 60 / seconds it is rpm."""
    steps = travels(table, closed)
    fastest = steps.max(axis=0) * len(steps) / (2 * np.pi)
    return int(fastest.argmax()), float(fastest.max())


def odd_angles(table: Floats, in_space: bool = False) -> tuple[str, ...]:
    """That a table [rad] looks to be told in degrees, as a sentence: no link turns through its neighbour."""
    joint, reach = largest_angle(table)
    if not reach > 180.0 * (1 + KEPT):
        return ()
    shown = f"{reach:.1f}" if reach < LONG else f"{reach:.3g}"
    named = f"{header(table.shape[1], in_space)[joint]} reaches {shown} degrees, more than half a turn"
    return (f"{named}. Angles of gaits are in radians: were they given in degrees?",)


def limit_lines(problem: Problem, table: Floats) -> list[str]:
    """Lines for a summary; none for a body that declares no limits."""
    return [*_angle_lines(problem, table), *_speed_lines(problem, table)]


def broken_limits(problem: Problem, table: Floats) -> list[str]:
    """Of these the warnings, as sentences."""
    warned = (line for line in limit_lines(problem, table) if line.startswith(WARNING))
    return [line.removeprefix(WARNING).strip() for line in warned]


def _angle_lines(problem: Problem, table: Floats) -> list[str]:
    declared = problem.body.joint_limit_deg
    if declared is None:
        return _impossible_lines(problem, table)
    low, high = np.degrees([table.min(), table.max()])
    reach = f"{low:z.1f} to {high:z.1f}" if isinstance(declared, tuple) else f"{largest_angle(table)[1]:.1f}"
    words = f"{limit_words(declared)} degrees"
    if problem.joint_limit_deg is None:
        return [f"joint limit       {words} SWITCHED OFF by `joint_limits`; joints reach {reach}"]
    worst = farthest(table, declared)
    if not worst.kept:
        named = f"{_columns(problem, table)[worst.joint]} reaches {worst.reach:.1f} degrees"
        return [f"warning           {named}, its limit is {worst.limit}", *_impossible_lines(problem, table)]
    return [f"joint limit       {words}; joints reach {reach}"]


def _impossible_lines(problem: Problem, table: Floats) -> list[str]:
    """Of a body without limits."""
    return [f"warning           {said}" for said in odd_angles(table, problem.lift is not None)]


def _columns(problem: Problem, table: Floats) -> list[str]:
    """What the columns of a table are called: in space a joint has two."""
    return header(table.shape[1], problem.lift is not None)


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
        named = _columns(problem, table)[joint]
        return [f"warning           {named} turns at {speed:.1f} rpm, its limit is {declared:g}"]
    return [f"joint speed       {declared:g} rpm; joints reach {speed:.1f}"]
