"""What a task asks of a gait, by symbols for the NLP and by numbers for everybody else.

Legend: B gaits, T steps, m joints, R rows, n gait parameters.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import cast

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.gaits import GaitFamily
from serpenoid.gaits.lifted import LiftedFamily
from serpenoid.mechanics import functions, kinematics
from serpenoid.mechanics.evaluate import evaluate
from serpenoid.model import Model
from serpenoid.objectives import Criteria, Demand, Term
from serpenoid.objectives.checked import scalar
from serpenoid.objectives.criteria import NEAR
from serpenoid.objectives.term import Rows
from serpenoid.optimise.customised import Customise, add_own
from serpenoid.problem import Task
from serpenoid.simulation.rollout import Batch


@dataclass(frozen=True)
class Asked:
    """The criteria with the bounds of their constraints."""

    criteria: Criteria

    @cached_property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper bounds of all constraints."""
        added = self.criteria.added
        lower, upper = ([ends[side] for ends in added] for side in (1, 2))
        for pairs in self.criteria.apart:
            lower, upper = [*lower, np.full(pairs.count, pairs.least)], [*upper, np.full(pairs.count, np.inf)]
        return np.concatenate([np.zeros(0), *lower]), np.concatenate([np.zeros(0), *upper])

    @cached_property
    def separable(self) -> bool:
        """`Criteria.separable`, found out once."""
        return self.criteria.separable

    @cached_property
    def always_dissipation(self) -> bool:
        """Whether the objective has a price of dissipation beside c."""
        price = ca.gradient(self.criteria.objective, self.criteria.dissipation)
        return not ca.simplify(ca.substitute(price, self.criteria.c, 0)).is_zero()

    @cached_property
    def _function(self) -> ca.Function:
        return self.criteria.function

    @cached_property
    def _apart(self) -> list[ca.Function]:
        table = ca.MX.sym("table", self.criteria.angles.numel())
        return [ca.Function("apart", [table], [pairs.value(table)]) for pairs in self.criteria.apart]

    @cached_property
    def _mapped(self) -> dict[int, ca.Function]:
        return {}

    def _over(self, count: int) -> ca.Function:
        if count not in self._mapped:
            self._mapped[count] = self._function.map("criteria_of_gaits", "serial", count, [4], [])
        return self._mapped[count]

    def evaluate(self, batch: Batch, tables: Floats, gaits: Floats, c: float) -> tuple[Floats, Floats]:
        """Objective (B,) and sum of the violations (B,) of simulated gaits."""
        count = len(gaits)
        moved = batch.poses[:, 1:] - batch.poses[:, :1]
        f, g = evaluate(self._over(count), moved, tables, batch.dissipation, gaits, np.full(1, c))
        for gaps in self._apart:
            g = np.vstack([g, np.hstack([gaps(table.ravel()).full() for table in tables])])
        lower, upper = self.bounds
        outside = np.maximum(lower[:, None] - g, 0) + np.maximum(g - upper[:, None], 0)
        return f[0], outside.sum(0)


def asked(task: Task, family: GaitFamily, customise: Customise | None = None, model: Model | None = None) -> Asked:
    """The criteria of a task for gaits of a family, with what the user adds; `model`: whose points may be asked for."""
    steps = family.rows - (not family.closed)
    chain = raised = None
    if model is not None and isinstance(family, LiftedFamily):
        raised = partial(_raised, model, family)
    elif model is not None:
        chain = partial(_chain, model)
    sizes = steps, family.rows, family.joints, family.size
    criteria = Criteria(*sizes, family.names, chain, family.pose_size, raised, _in_place(task, family))
    for term in task.objectives:
        criteria.also_minimise(term.weight * _value(term, criteria))
    criteria.also_minimise(criteria.c * criteria.dissipation)
    for demand in task.demands:
        _require(demand, criteria)
    if customise is not None:
        add_own(customise, criteria)
    return Asked(criteria)


def _in_place(task: Task, family: GaitFamily) -> bool:
    """Whether demands want the cycle to end where it began."""
    rows = Rows(task.steps, family.joints, family.closed)
    ways = [ask for demand in task.demands for ask in demand.asks(rows) if ask.quantity == "displacement"]
    return any(way.upper <= NEAR for way in ways)


def _value(term: Term, criteria: Criteria) -> ca.SX:
    """What a term gives; InputError, by its kind, where that is no number of the criteria."""
    name, value = f"[[task.objectives]] `{term.kind}`: `expression`", cast("ca.SX | None", term.expression(criteria))
    if value is None:
        raise InputError(f"{name} must give back a number, got None. Does it lack a `return`?")
    return scalar(value, name, criteria.known)


def _require(demand: Demand, criteria: Criteria) -> None:
    """Let a demand ask; InputError, by its kind, where it gives back what is not looked at."""
    require: Callable[[Criteria], object] = demand.require
    returned = require(criteria)
    if returned is not None:
        got = f"gave back {type(returned).__name__}, which is not looked at"
        raise InputError(
            f"[[task.demands]] `{demand.kind}`: `require` {got}. Call of.subject_to(..., lower, upper) in it."
        )


def _raised(model: Model, family: LiftedFamily, gait: ca.SX, row: int) -> ca.SX:
    """Vertices (3, N) in the body frame at a row of the table."""
    coordinates = family.at(gait[family.indices[row].tolist()], ca.SX(family.data[row]))
    return functions.lifted_row(model.structure, family.lift)(coordinates, model.parameters)[0]


def _chain(model: Model, angles: ca.SX) -> ca.SX:
    """Vertices (2, N) in the body frame of joint angles as they are commanded."""
    refuse_other_angles(model)
    body = model.body
    return kinematics.vertices(angles, ca.SX(body.edges), ca.SX(body.vertex_weights), model.structure)[0]


def refuse_other_angles(model: Model) -> None:
    """InputError where the body has other joint angles than those of the table."""
    if model.actuation_effects:
        raise InputError(
            f"[[effects]] `{model.actuation_effects[0].name}` makes other joint angles than those commanded: goals for "
            "single points of the body are not known with it. Ask for the centre, or leave the effect out."
        )
