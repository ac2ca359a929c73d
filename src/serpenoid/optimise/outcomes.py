"""What one cycle of a motion makes of all that a problem asks, in words: of an optimum, and of a gait that is given."""

from __future__ import annotations

from collections.abc import Sequence

from serpenoid.body import Floats
from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.obstacles import Obstacle
from serpenoid.objectives.term import Demand, Goal, Played, told
from serpenoid.optimise.clear.apart import pairs_of
from serpenoid.optimise.clear.clearance import Clearance
from serpenoid.optimise.clear.obstacles import Obstacles
from serpenoid.optimise.solution import SelfClear
from serpenoid.problem import Problem
from serpenoid.simulation.mesh import FINER
from serpenoid.simulation.problem import finer_gait
from serpenoid.trajectory import Trajectory


def goal_words(problem: Problem, table: Floats, motion: Trajectory, own: SelfClear | None) -> list[str]:
    """What is said of every objective, demand and prescribed heading; own: how far the body is from itself."""
    task, rows = problem.task, motion.steps_per_cycle + 1
    played = Played(motion.poses[:rows], motion.vertices[:rows], table)
    goals: list[Goal] = [*task.objectives, *task.demands]
    words = [_numbered(goal, task.demands, goal.outcome(played)) for goal in goals]
    words += [] if own is None else [own.goal]
    heading = 0.0 if task.constraints.straight else task.constraints.heading_change_rad
    if heading is not None:
        words.append(told(f"heading change {heading:g} rad", float(played.poses[-1, 2]) - heading, "rad"))
    return [said for said in words if said]


def _numbered(goal: Goal, demands: Sequence[Demand], said: str) -> str:
    """Which of several demands of its kind it is, counted as complaints about the file count them."""
    alike = [i for i, demand in enumerate(demands, start=1) if demand.kind == goal.kind]
    which = next((i for i in alike if demands[i - 1] is goal), None)
    return said if which is None or len(alike) == 1 or not said else f"demand {which}: {said}"


def clear_of_obstacles(problem: Problem, table: Floats, motion: Trajectory) -> Clearance | None:
    """How near the body comes to obstacles between all rows of a cycle; None where there are none."""
    steps = motion.steps_per_cycle
    return _obstacles(problem, steps).clearance(motion.poses[: steps + 1], table)


def fine_clear_of_obstacles(problem: Problem, table: Floats, finest: Trajectory) -> Clearance | None:
    """The same of a cycle with FINER times as many steps, the last of `on_meshes`; None where that failed, too."""
    steps = FINER * (len(table) - problem.task.transient)
    return _obstacles(problem, steps).of_gait(*finer_gait(problem, table, FINER), finest)


def _obstacles(problem: Problem, steps: int) -> Obstacles:
    found = Criteria(1, 1, problem.body.joint_count, 0)
    for demand in problem.task.demands:
        if isinstance(demand, Obstacle):
            demand.require(found)
    return Obstacles(tuple(found.clear_of), problem.model, steps, not problem.task.transient)


def clear_of_itself(problem: Problem, table: Floats) -> SelfClear | None:
    """How near the body comes to itself at any time; None where nobody asks."""
    asked = pairs_of(problem.model, problem.task.demands)
    return None if asked is None else SelfClear.of(*asked, table, not problem.task.transient)
