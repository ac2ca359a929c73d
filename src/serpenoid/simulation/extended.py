"""Forward simulation of extended models: the same roots, with what the effects add.

Legend: R rows, S steps, M vertices.
"""

from __future__ import annotations

import numpy as np

from serpenoid import group
from serpenoid.body import Floats
from serpenoid.model import Model
from serpenoid.simulation.balance import Placed, solve_balance
from serpenoid.simulation.chain import solve_chain
from serpenoid.simulation.steps import Steps, solve_steps


def solve_independent(model: Model, before: Floats, after: Floats, times: Floats) -> Steps:
    """Relative poses of steps that need no others: elements (4, M S), times (B, R) [s] of B sequences, R - 1 steps."""
    plain = solve_steps(model, before, after)
    if model.is_plain:
        return plain
    guess = np.where(np.isfinite(plain.relative), plain.relative, 0.0)
    spans = np.column_stack([times[:, :-1].ravel(), times[:, 1:].ravel()])
    return solve_balance(model, Placed(before, after, spans, np.zeros_like(guess)), guess)


def solve_extended(model: Model, elements: Floats, times: Floats, start: Floats | None) -> Steps:
    """Relative poses of a sequence of shapes: elements (4, M R) at `times` (R,) [s], first pose `start` on the floor.

    With inertia the body is at rest before the first row. `start` (K + 1, 3): it is moving already, and these are its
    first poses; where a model knows place or history its first K steps are these, and their momentum is carried on.
    """
    m = model.structure.elements
    before, after = elements[:, :-m], elements[:, m:]
    known = np.zeros((1, 3)) if start is None else np.atleast_2d(np.asarray(start, float))
    plain = solve_steps(model, before, after)
    if model.is_plain:
        return plain
    guess = np.where(np.isfinite(plain.relative), plain.relative, 0.0)
    starts = group.accumulate(guess, known[0])[:-1]
    steps = solve_balance(model, Placed(before, after, np.column_stack([times[:-1], times[1:]]), starts), guess)
    if not in_order(model):
        return steps
    near = np.where(steps.sound[:, None], steps.relative, guess)
    return solve_chain(model, before, after, times, known, near)


def in_order(model: Model) -> bool:
    """Whether steps need those before them."""
    return model.knows("place") or model.knows("history")
