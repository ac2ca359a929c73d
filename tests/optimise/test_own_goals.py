"""A goal of one's own is one file; what is wrong with it is told, and not passed over."""

from __future__ import annotations

from typing import Literal

import casadi as ca
import pytest

import serpenoid.objectives.bending as folder
from serpenoid.errors import InputError
from serpenoid.gaits import EllipseGait
from serpenoid.objectives import Criteria, Demand, Term, terms
from serpenoid.optimise.asked import asked
from specimens import problem

FAMILY = EllipseGait().of(9, 30)


class Ahead(Term):
    """A term of one's own: minus the way along x."""

    kind: Literal["ahead"] = "ahead"

    def expression(self, of: Criteria) -> ca.SX:
        return -of.poses[0, -1]


class Nameless(Ahead):
    kind: Literal["nameless"]  # type: ignore[assignment]


class Takes(Ahead):
    kind: Literal["position"] = "position"  # type: ignore[assignment]


class Lacking(Term):
    kind: Literal["lacking"] = "lacking"


@pytest.mark.parametrize(
    ("goal", "said"),
    [
        (Nameless, "`Nameless`: `kind` must be a literal and its own default.*without a default"),
        (Takes, "`kind` must be a word of its own, got `position`"),
        (Lacking, "`Lacking`: must have a method `expression`, got none"),
    ],
)
def test_a_file_with_a_kind_that_cannot_be_asked_for_is_refused(
    goal: type[Term], said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before, it took another kind's place, or was not there, without a word."""
    monkeypatch.setattr(folder, "Own", goal, raising=False)
    with pytest.raises(InputError, match=said):
        terms.__wrapped__()


class Returns(Demand):
    kind: Literal["returns"] = "returns"

    def require(self, of: Criteria) -> None:
        return of.displacement - 0.3  # type: ignore[no-any-return]


class Forgetful(Ahead):
    def expression(self, of: Criteria) -> ca.SX:
        super().expression(of)  # type: ignore[return]


class Many(Ahead):
    def expression(self, of: Criteria) -> ca.SX:
        return of.poses[:2, -1]


@pytest.mark.parametrize(
    ("goal", "said"),
    [
        (Returns(), "`returns`: `require` gave back SX, which is not looked at. Call of.subject_to"),
        (Forgetful(), "`ahead`: `expression` must give back a number, got None. Does it lack a `return`"),
        (Many(), "`ahead`: `expression`: takes one number, got 2 x 1"),
    ],
)
def test_a_goal_of_ones_own_that_asks_nothing_is_refused(goal: Term | Demand, said: str) -> None:
    """A demand that gave back what it meant to ask was met by any gait."""
    task = problem("reference-optimum", "task.steps=30").task
    changed = {"demands": (goal,)} if isinstance(goal, Demand) else {"objectives": (goal,)}
    with pytest.raises(InputError, match=said):
        asked(task.model_copy(update=changed), FAMILY)
