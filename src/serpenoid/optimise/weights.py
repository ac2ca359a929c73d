"""Whether what is minimised is large enough for the tolerances that an optimum is certified by, which are absolute."""

from __future__ import annotations

from collections.abc import Iterable

from serpenoid.errors import InputError
from serpenoid.problem import Problem

LIGHTEST = 1e-3  # of the heaviest term: below, any gait is stationary to 1e-8, and optima that differ cost the same
HEAVY = 1e4  # above, rounding may keep optima from being stationary to 1e-8


def check_weights(problem: Problem, values: Iterable[float]) -> None:
    """InputError where the heaviest term of the objective, or c (each of `values`), is too light to be minimised."""
    for c in values:
        if 0 < (heaviest := _heaviest(problem, c)) < LIGHTEST:
            raise InputError(
                f"[[task.objectives]] weight: the largest of the weights and c must be at least {LIGHTEST:g}, got "
                f"{heaviest:g} at c = {c:g}. Multiply them all, c too, by one factor: the gait stays the same."
            )


def why_unsolved(problem: Problem) -> str | None:
    """What heavy weights have to do with a search that does not converge; None: nothing."""
    heaviest = _heaviest(problem, problem.task.c)
    if heaviest < HEAVY:
        return None
    return (
        f"[[task.objectives]] weight: the largest of the weights and c is {heaviest:g}, where rounding may hide the "
        "optimum. Divide them all, c too, by one factor: the gait stays the same."
    )


def _heaviest(problem: Problem, c: float) -> float:
    return max([c, *(term.weight for term in problem.task.objectives)])
