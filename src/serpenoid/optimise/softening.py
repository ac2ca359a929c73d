"""Coulomb friction is approached from the soft side, from linear drag on: each optimum starts the search in the next.

The kinks of hard friction lie close together along a search, and IPOPT's quadratic models hold only between them. Where
friction gives way at any slip, it is linear drag with the ratio eps^2, whose optima are found from anywhere; from there
each harder medium's optimum is a few steps away.
"""

from __future__ import annotations

from serpenoid.problem import Problem

SOFTEST = 1.0  # of the element's own way; softer still is linear drag
FACTOR = 10**0.5  # from one to the next
ITERATIONS = 200  # a search in a medium with kinks that takes longer has gone astray


def softer(problem: Problem) -> Problem | None:
    """The same problem with the next softer friction; None for linear drag."""
    medium = problem.medium
    if medium.law != "coulomb":
        return None
    softening = medium.softening * FACTOR
    if softening <= SOFTEST:
        update: dict = {"softening": softening}
    else:
        ratio = medium.anisotropy_ratio**2
        update = {"law": "viscous", "anisotropy_ratio": ratio, "anisotropy_ratio_bounds": None}
    return problem.model_copy(update={"medium": medium.model_copy(update=update)})
