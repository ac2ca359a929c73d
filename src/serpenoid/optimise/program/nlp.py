"""The gait NLP of a problem, to open: its symbols, its Functions, to call, differentiate, save and generate as C.

`gait_nlp` gives the symbols, `nlp_arguments` the numbers: with both, any solver that CasADi knows can solve it.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.gaits import Gait
from serpenoid.optimise.asked import Customise, asked
from serpenoid.optimise.clear.obstacles import Obstacles
from serpenoid.optimise.program.limits import even_rows
from serpenoid.optimise.program.prepared import Carried, PreparedNLPs
from serpenoid.optimise.program.transcription import GaitNLP
from serpenoid.optimise.step.motion_law import motion_law
from serpenoid.problem import Problem
from serpenoid.simulation.callers import gait_of, problem_of, whole


def gait_nlp(
    problem: Problem | str | Path,
    gait: Gait | None = None,
    path_rows: int = 0,
    portable: bool = False,
    customise: Customise | None = None,
) -> GaitNLP:
    """The NLP of `problem` in the family of `gait` (default the problem's); see GaitNLP.

    path_rows: at how many rows, spread evenly, joint angles and their changes are limited (T of a closed gait: at all).
    """
    problem = _of_one_model(problem)
    family = problem.family_of(None if gait is None else gait_of(gait))
    law = motion_law(problem.model, family, portable)
    criteria = asked(problem.task, family, customise, problem.model).criteria
    obstacles = Obstacles(tuple(criteria.clear_of), problem.model, law.steps, family.closed)
    return GaitNLP(law, criteria, _rows(path_rows, law.steps), portable, watch=obstacles.first())


def nlp_arguments(
    problem: Problem | str | Path, gait: Gait | None = None, path_rows: int = 0, customise: Customise | None = None
) -> dict[str, Floats]:
    """Start `x0`, parameters `p` and bounds `lbx`, `ubx`, `lbg`, `ubg` of the NLP that `gait_nlp` makes of the same.

    The start is the simulated motion of `gait` (default the problem's), inside the bounds: it meets all equations.
    """
    problem = _of_one_model(problem)
    numbers = PreparedNLPs(problem, customise, None if gait is None else gait_of(gait), {})
    carried = Carried(tuple(even_rows(numbers.steps, _rows(path_rows, numbers.steps))), numbers.obstacles.first())
    bounds = numbers.bounds(carried)
    own = numbers.own_start() if gait is None else np.clip(numbers.family.start(), *numbers.gait_bounds())
    return {
        "x0": numbers.start(own),
        "p": numbers.parameters(problem.task.c, carried.rows),
        "lbx": bounds.lbx,
        "ubx": bounds.ubx,
        "lbg": bounds.lbg,
        "ubg": bounds.ubg,
    }


def _rows(count: int, steps: int) -> int:
    """How many rows are limited, checked."""
    if whole("path_rows", count, 0) > steps:
        raise InputError(f"`path_rows` must be at most {steps}, the steps of a cycle, got {count}.")
    return count


def _of_one_model(given: Problem | str | Path) -> Problem:
    """The problem; refused where one gait must serve several models: the NLP that is opened has one."""
    problem = problem_of(given)
    if problem.task.robust is not None:
        raise InputError(
            f"{problem.name}: [task.robust] asks for several models, and the NLP that is opened has one. Open one for "
            'each: problem.model_copy(update={"task": problem.task.model_copy(update={"robust": None})}).'
        )
    return problem
