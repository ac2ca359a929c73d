"""The gait NLP of a problem, to open: its symbols, its Functions, to call, differentiate, save and generate as C."""

from __future__ import annotations

from serpenoid.gaits import Gait
from serpenoid.optimise.asked import Customise, asked
from serpenoid.optimise.motion_law import motion_law
from serpenoid.optimise.obstacles import Obstacles
from serpenoid.optimise.transcription import GaitNLP
from serpenoid.problem import Problem


def gait_nlp(
    problem: Problem,
    gait: Gait | None = None,
    path_rows: int = 0,
    portable: bool = False,
    customise: Customise | None = None,
) -> GaitNLP:
    """The NLP of `problem` in the family of `gait` (default the problem's); see GaitNLP."""
    family = problem.family_of(gait)
    law = motion_law(problem.model, family, portable)
    criteria = asked(problem.task, family, customise, problem.model).criteria
    obstacles = Obstacles(tuple(criteria.clear_of), problem.model, law.steps, family.closed)
    return GaitNLP(law, criteria, path_rows, portable, watch=obstacles.first())
