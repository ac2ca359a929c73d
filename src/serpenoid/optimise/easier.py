"""A hard problem is approached from an easier one: its optimum is where the search begins, and that may have an easier.

    friction with kinks   <-  the next softer friction <- ... <- linear drag
    a free table          <-  every fourth of its rows
    beside obstacles      <-  the same without them

Kinks of hard friction lie close together along a search, and quadratic models hold only between them; linear drag's
optima are found from anywhere. A random table needs as many iterations on few rows as on many, and an iteration costs
in proportion to the rows. Obstacles put thousands of constraints into an NLP whose first iterations only learn to move.
"""

from __future__ import annotations

from dataclasses import dataclass

from serpenoid.body import Floats
from serpenoid.gaits import GaitFamily
from serpenoid.objectives.obstacles import Obstacle
from serpenoid.problem import Problem

# all measured beside other values in results/benchmarks/approach.md (benchmarks/approach.py):
SOFTEST = 1.0  # of the element's own way; softer still is linear drag
SOFTER = 10**0.5  # from one friction to the next
FEWER = 4  # rows of the table to one of the rough table: beside a disc two take 1.5 times as long, eight 1.8 times
LEAST = 20  # rows of a rough table: from ten, the search on all rows takes longer than the rough one saves


@dataclass(frozen=True)
class Easier:
    """An easier problem. fewer: rows of the table to one of its rows; exact: its own optimum is worth finding."""

    problem: Problem
    fewer: int = 1
    exact: bool = False

    def to(self, q: Floats, family: GaitFamily) -> Floats:
        """Where it begins, from gait q of the harder problem's family."""
        return q if self.fewer == 1 else q.reshape(family.rows, family.joints)[:: self.fewer].ravel()

    def back(self, q: Floats, family: GaitFamily) -> Floats:
        """Where the harder problem begins, from gait q of the easier problem's family."""
        return q if self.fewer == 1 else family.on_finer_rows(q, self.fewer)


def easier(problem: Problem, family: GaitFamily, given: bool) -> Easier | None:
    """The next easier problem, None where none helps; given: the start is good, or terms are the user's."""
    soft = softer(problem)
    if soft is not None:
        return Easier(soft, exact=True)
    if given:
        return None
    rough = on_fewer_rows(problem, family)
    if rough is not None:
        return Easier(rough, FEWER)
    free = without_obstacles(problem)
    return None if free is None else Easier(free)


def softer(problem: Problem) -> Problem | None:
    """The same problem with the next softer law; None for linear drag, and for laws that need none."""
    medium, law = problem.medium, problem.model.law
    if law.softer is None:
        return None
    softening = medium.softening * SOFTER
    if softening <= SOFTEST:
        return problem.model_copy(update={"medium": medium.model_copy(update={"softening": softening})})
    ratio, name = law.form_ratio(medium.anisotropy_ratio), law.softer.name
    drag = medium.model_copy(update={"law": name, "anisotropy_ratio": ratio, "anisotropy_ratio_bounds": None})
    effects = tuple(e for e in problem.effects if e.effect.acts_in(name))  # not what is a number of the harder law
    return problem.model_copy(update={"medium": drag, "effects": effects})


def on_fewer_rows(problem: Problem, family: GaitFamily) -> Problem | None:
    """The same problem of free tables on every fourth row; None where too few are left."""
    steps = problem.task.steps
    if not family.free or steps % FEWER or steps < FEWER * LEAST:
        return None
    return _with(problem, steps=steps // FEWER)


def without_obstacles(problem: Problem) -> Problem | None:
    """The same problem with nothing in the way; None where nothing is."""
    left = tuple(demand for demand in problem.task.demands if not isinstance(demand, Obstacle))
    return None if len(left) == len(problem.task.demands) else _with(problem, demands=left)


def _with(problem: Problem, **changes: object) -> Problem:
    return problem.model_copy(update={"task": problem.task.model_copy(update=changes)})
