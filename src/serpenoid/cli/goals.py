"""Lines of a summary that say what a gait makes of what its problem file asks."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from serpenoid.body import Floats
    from serpenoid.optimise.clearance import Clearance
    from serpenoid.optimise.solution import SelfClear
    from serpenoid.problem import Problem
    from serpenoid.trajectory import Trajectory


def goal_lines(problem: Problem, table: Floats, motion: Trajectory, own: SelfClear | None) -> list[str]:
    """One line for every goal there is something to say of."""
    from serpenoid.optimise.outcomes import goal_words

    return [f"goal              {words}" for words in goal_words(problem, table, motion, own)]


def clear_lines(obstacles: Clearance | None, own: SelfClear | None) -> list[str]:
    """What is proven of the body's distance from obstacles and from itself."""
    lines = [f"clearance         {obstacles.words}"] if obstacles else []
    return [*lines, *([f"from itself       {own.words}"] if own else [])]


def asked_lines(problem: Problem, table: Floats, motion: Trajectory) -> list[str]:
    """All of them for a gait that was simulated; the first of its cycles counts."""
    from serpenoid.optimise.outcomes import clear_of_itself, clear_of_obstacles

    own = clear_of_itself(problem, table)
    lines = goal_lines(problem, table, motion, own)
    return [*lines, *clear_lines(clear_of_obstacles(problem, table, motion), own)]
