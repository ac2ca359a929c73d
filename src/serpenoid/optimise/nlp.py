"""The gait NLP of a problem, to open: its symbols, its Functions, to call, differentiate, save and generate as C."""

from __future__ import annotations

from pathlib import Path

from serpenoid.gaits import Gait
from serpenoid.optimise.asked import Customise, asked
from serpenoid.optimise.motion_law import motion_law
from serpenoid.optimise.obstacles import Obstacles
from serpenoid.optimise.transcription import GaitNLP
from serpenoid.problem import Problem
from serpenoid.simulation.callers import gait_of, problem_of


def gait_nlp(
    problem: Problem | str | Path,
    gait: Gait | None = None,
    path_rows: int = 0,
    portable: bool = False,
    customise: Customise | None = None,
) -> GaitNLP:
    """The NLP of `problem` in the family of `gait` (default the problem's); see GaitNLP."""
    problem = problem_of(problem)
    family = problem.family_of(None if gait is None else gait_of(gait))
    law = motion_law(problem.model, family, portable)
    criteria = asked(problem.task, family, customise, problem.model).criteria
    obstacles = Obstacles(tuple(criteria.clear_of), problem.model, law.steps, family.closed)
    return GaitNLP(law, criteria, path_rows, portable, watch=obstacles.first())
