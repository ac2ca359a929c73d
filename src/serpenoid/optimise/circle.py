"""That a gait which was to lead far leads round a circle: each cycle repeats the turn of the one before.

a turn of w radians a cycle: the heading, and with it the place, is back after 2 pi / |w| cycles
"""

from __future__ import annotations

from math import degrees, remainder, tau

from serpenoid.optimise.unmoved import ASKING
from serpenoid.problem import Problem

TURNING = {"heading", "position", "path", "reach"}  # goals that may ask for a turn
FEW_DEGREES = 5.0  # in a cycle: a circle of 72 cycles


def circle_note(problem: Problem, turn: float) -> str | None:
    """What to say of a gait whose cycle turns the body by so much [rad]; None where it does not, or was asked to."""
    task = problem.task
    kinds = {goal.kind for goal in (*task.objectives, *task.demands)}
    straight, heading = task.constraints.straight, task.constraints.heading_change_rad
    left = abs(degrees(remainder(turn, tau)))  # a whole turn is none
    if task.transient or straight or heading is not None or not kinds & ASKING or kinds & TURNING or left < FEW_DEGREES:
        return None
    return (
        f"turns {abs(degrees(turn)):.0f} degrees per cycle, so that it comes back after about {360 / left:.2g} cycles; "
        "`straight = true` in [task.constraints] asks for none"
    )
