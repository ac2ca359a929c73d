"""Joint limits on all rows by an exchange of a few constraint rows."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.optimise.program.limits import even_rows, exchange, path_limits, violations
from serpenoid.optimise.program.prepared import Carried
from serpenoid.optimise.solver import GaitSolver, Run
from serpenoid.optimise.starts import random_gaits
from specimens import problem


def test_speed_limit_and_cycle_duration_give_the_change_per_step() -> None:
    limits = path_limits(problem("snake10"))
    assert limits.upper[:10] == pytest.approx(np.deg2rad(60))
    assert limits.upper[10:] == pytest.approx(57 / 60 * 2 * np.pi * 5.0 / 50)


def test_violations_see_rows_and_changes_and_the_step_from_last_to_first() -> None:
    limits = path_limits(problem("snake10"))
    table = np.zeros((50, 10))
    table[:25, 3] = 1.0  # within 60 degrees, but it jumps by one radian twice
    excess = violations(table, limits)
    assert (excess[:, :10] < 0).all()
    jumps = np.argwhere(excess[:, 10:] > 0).tolist()
    assert jumps == [[24, 3], [49, 3]]
    assert excess.max() == pytest.approx(1.0 - limits.upper[10])


def test_an_exchange_takes_in_the_worst_rows_and_keeps_those_that_bind() -> None:
    limits = path_limits(problem("reference-optimum"))
    rows = even_rows(50, 10)
    table = np.zeros((50, 10))
    table[7, 2] = 1.2  # violated, not among the rows
    table[rows[3], 5] = np.deg2rad(60)  # binds
    new, staying = exchange(rows, frozenset(), violations(table, limits))
    assert 7 in new
    assert rows[3] in new
    assert len(set(new)) == len(new) == 10
    assert staying == {7, rows[3]}  # they stay whatever comes next


def test_rows_grow_where_an_exchange_alone_does_not_help() -> None:
    limits = path_limits(problem("reference-optimum"))
    rows = even_rows(50, 10)
    table = np.zeros((50, 10))
    table[rows[0], 0] = 1.2  # violated although its row is there already
    assert len(exchange(rows, frozenset(), violations(table, limits))[0]) == 20
    assert len(exchange(list(range(50)), frozenset(), violations(table, limits))[0]) == 50


@pytest.mark.parametrize("steps", [7, 50])
def test_few_rows_give_the_optimum_of_all_rows(steps: int) -> None:
    solver = GaitSolver(problem("snake10", f"task.steps={steps}"))
    (start,) = random_gaits(solver, 1, seed=1)
    few, full = solver.solve(start, 0.5), solver.solve(start, 0.5, Run(carried=Carried(tuple(range(steps)))))
    assert few.outcome.status.ok
    assert full.outcome.status.ok
    assert few.outcome.objective == pytest.approx(full.outcome.objective, abs=1e-8)
