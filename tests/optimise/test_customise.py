"""An objective or a constraint of the user's own, in a few lines of Python."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
import pytest

from serpenoid.errors import InputError
from serpenoid.gaits import EllipseGait
from serpenoid.objectives import Criteria
from serpenoid.optimise.asked import Customise, asked
from serpenoid.optimise.solve import solve
from serpenoid.results import solution_record
from serpenoid.status import Status
from specimens import problem

FAMILY = EllipseGait().of(9, 30)


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


def foreign(of: Criteria) -> None:
    of.minimise(of.displacement + ca.SX.sym("y"))


def off_the_end(of: Criteria) -> None:
    of.minimise(of.poses[0, 1000])


def branching(of: Criteria) -> None:
    of.minimise(of.displacement if of.dissipation > 1 else of.dissipation)


def misspelt(of: Criteria) -> None:
    of.minimise(of.displacment)  # type: ignore[attr-defined]


def set_misspelt(of: Criteria) -> None:
    of.objectve = of.dissipation  # type: ignore[attr-defined]


def set_what_is_made(of: Criteria) -> None:
    of.displacement = of.dissipation  # type: ignore[misc]


MISTAKES = {  # what customise does: what is said of it
    lambda of: of.displacement: r"returned SX, which is not looked at\. Call minimise",
    lambda: None: r"must be a function of one argument.* does not take one argument",
    "displacement": r"must be a function of one argument.*got str",
    foreign: r"minimise: `y` is no symbol of these criteria",
    misspelt: r"criteria: there is no `displacment`\. Did you mean `displacement`\?",
    set_misspelt: r"criteria: there is no `objectve`\. Did you mean `objective`\?",
    set_what_is_made: r"criteria: `displacement` cannot be set\. Ask by minimise",
    off_the_end: r"`customise` off_the_end: Slice .* out of bounds with supplied length of 31\. Build it of",
    branching: r"`customise` branching: Cannot compute the truth value .* ca\.if_else, not if",
    lambda of: of.minimise("displacement"): r"minimise: takes an expression, got str",
    lambda of: of.minimise(ca.MX.sym("x")): r"minimise: takes an expression, got casadi\.MX",
    lambda of: of.also_minimise(of.poses[:2, -1]): r"also_minimise: takes one number, got 2 x 1\. Sum them",
    lambda of: of.minimise(
        math.sin(of.displacement)
    ): r"minimise: is not a number \(NaN\), whatever the gait.*not math",
    lambda of: of.subject_to(of.displacement, 1.0, 0.0): r"needs lower <= upper, got 1\.0 and 0\.0",
    lambda of: of.subject_to(of.displacement > 0.3, 0, 1): r"subject_to: `.*` is a comparison, .*subject_to\(e",
    lambda of: of.minimise(ca.logic_or(of.displacement < 0.3, of.c > 1)): r"minimise: `.*` is a comparison",
    lambda of: of.subject_to(of.displacement, np.nan, 1.0): r"needs lower <= upper, got nan and 1\.0",
    lambda of: of.subject_to(of.displacement, "a", 1.0): r"`lower` must be numbers, got str",
    lambda of: of.subject_to(of.joint_angles, 0.0, np.ones(3)): r"`upper` must be one number or 270, .* got 3",
    lambda of: of.keep_clear(lambda points: 3.0): r"keep_clear: must give as many gaps for every point, got 1 for one",
    lambda of: of.keep_clear(lambda points: points[0, :] + of.dissipation): r"`dissipation` is no symbol",
}


@pytest.mark.parametrize("mistake", MISTAKES, ids=range(len(MISTAKES)))
def test_a_mistake_in_a_function_of_ones_own_is_told_in_words(mistake: object) -> None:
    with pytest.raises(InputError, match=MISTAKES[mistake]):
        asked(problem("reference-optimum", "task.steps=30").task, FAMILY, mistake)  # type: ignore[arg-type]


def test_criteria_are_asked_whether_they_have_something_as_any_object_is() -> None:
    of = Criteria(3, 3, 1, 0)
    assert (hasattr(of, "displacement"), hasattr(of, "displacment"), hasattr(of, "__len__")) == (True, False, False)


def test_own_exceptions_of_the_function_pass_as_they_are() -> None:
    def slip(of: Criteria) -> None:
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        asked(problem("reference-optimum", "task.steps=30").task, FAMILY, slip)


@pytest.mark.parametrize(
    "add",
    [
        lambda of: of.minimise(ca.log(-of.dissipation)),
        lambda of: of.subject_to(ca.sqrt(of.displacement - 10), 0.0, 1.0),
    ],
)
def test_what_is_not_a_number_is_a_failure_in_words_and_no_cost_of_zero(add: Customise) -> None:
    found = solve(problem("reference-optimum", "task.steps=30", "body.vertices=5"), starts=2, customise=add)
    best = found.best
    assert best.status is Status.NOT_A_NUMBER
    assert "keep roots, logarithms and quotients defined" in best.message
    assert np.isnan(best.objective)
    assert solution_record(best)["cost"] is None
