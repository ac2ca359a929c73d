"""An objective or a constraint of the user's own, in a few lines of Python."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from serpenoid.objectives import Criteria
from serpenoid.optimise.solve import solve
from specimens import problem


def test_a_constraint_of_ones_own_is_met_and_costs() -> None:
    asked = problem("reference-optimum")

    def gentle(nlp: Criteria) -> None:
        nlp.subject_to(nlp.dissipation, 0.0, 0.05)

    free, bound = solve(asked, starts=3).best, solve(asked, starts=3, customise=gentle).best
    assert bound.status.ok
    assert bound.trajectory.dissipation == pytest.approx(0.05, abs=1e-8)  # it binds
    assert bound.cost > free.cost + 1e-3
    assert bound.residuals.largest <= 1e-8


def test_dissipation_as_ones_own_objective_is_the_built_in_one() -> None:
    built_in = solve(problem("reference-optimum", "task.c=0.8"), starts=3).best

    def priced(nlp: Criteria) -> None:
        nlp.also_minimise(0.8 * nlp.dissipation)

    own = solve(problem("reference-optimum"), starts=3, customise=priced).best
    assert own.status.ok
    cost = -own.trajectory.displacement + 0.8 * own.trajectory.dissipation
    assert cost == pytest.approx(built_in.cost, abs=1e-8)


def test_an_objective_of_ones_own_replaces_the_built_in_one() -> None:
    def turn(nlp: Criteria) -> None:
        nlp.minimise(-nlp.heading_change)

    s = solve(problem("reference-optimum", "task.c=5.0"), starts=3, customise=turn).best
    assert s.status.ok
    farthest = solve(problem("reference-optimum"), starts=3).best
    assert s.trajectory.heading_change > abs(farthest.trajectory.heading_change)


def test_joint_angles_can_be_constrained_as_one_likes() -> None:
    def equal_ends(nlp: Criteria) -> None:
        nlp.subject_to(ca.sum2(nlp.joint_angles)[0] - ca.sum2(nlp.joint_angles)[-1], 0.0, 0.0)

    s = solve(problem("reference-optimum", "task.steps=30"), starts=2, customise=equal_ends).best
    assert s.status.ok
    sums = s.table.sum(0)
    assert sums[0] == pytest.approx(sums[-1], abs=1e-8)
    assert np.abs(sums).max() > 1e-3
