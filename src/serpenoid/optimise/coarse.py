"""Free tables are looked for on a quarter of their rows first: what is found there is a good start on all of them.

A random table needs as many iterations on few rows as on many, and an iteration costs in proportion to the rows. Beside
obstacles it is no help: bodies leap farther between fewer rows, through what is between them.
"""

from __future__ import annotations

from serpenoid.body import Floats
from serpenoid.gaits import GaitFamily
from serpenoid.objectives.obstacles import Obstacle
from serpenoid.problem import Problem

FACTOR = 4
LEAST = 20  # rows of a rough table: fewer do not tell a wave's direction well


def coarser(problem: Problem, family: GaitFamily) -> Problem | None:
    """The same problem on a quarter of the rows, None where that is no help."""
    steps = problem.task.steps
    if not family.free or steps % FACTOR or steps < FACTOR * LEAST or has_obstacles(problem):
        return None
    return problem.model_copy(update={"task": problem.task.model_copy(update={"steps": steps // FACTOR})})


def has_obstacles(problem: Problem) -> bool:
    """Whether a demand holds at all times: obstacles."""
    return any(isinstance(demand, Obstacle) for demand in problem.task.demands)


def on_coarser_rows(q: Floats, family: GaitFamily) -> Floats:
    """Every fourth row of the free table q (n,)."""
    return q.reshape(family.rows, family.joints)[::FACTOR].ravel()
