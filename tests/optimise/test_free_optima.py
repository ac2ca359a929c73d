"""Invariants of optima of free gaits: what mirrors, reverses or rescales a problem does so with its optimum.

Searches that begin at such twins make the same iterates up to rounding, which KKT residuals of 1e-8 bound.
"""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.body import Floats
from serpenoid.gaits import TableGait
from serpenoid.optimise.solution import Solution
from serpenoid.optimise.solve import solve_from
from specimens import problem, random_table

SMALL = "body.vertices=5", "task.steps=12", "task.c=0.3"
FAR = "task.objectives=[{kind='displacement'},{kind='bending',weight=0.03}]"
SAME = 1e-6  # of angles: 1e-8 in stationarity over the least curvature


def begin(*changes: str) -> Floats:
    """A random smooth table within the limits."""
    return np.clip(random_table(problem("reach", *SMALL, *changes).model, np.random.default_rng(3), 12), -0.8, 0.8)


def optimum(table: Floats, *changes: str) -> Solution:
    """From that table."""
    found = solve_from(problem("reach", *SMALL, *changes), TableGait.from_angles(table))
    assert found.residuals.largest <= 1e-8  # an optimum of the mesh, whether or not that is fine
    return found


@pytest.fixture(scope="module")
def plain() -> Solution:
    """As far as possible with little bending."""
    return optimum(begin(), FAR)


def test_a_mirrored_start_finds_the_mirrored_optimum(plain: Solution) -> None:
    mirrored = optimum(-begin(), FAR)
    assert mirrored.cost == pytest.approx(plain.cost, abs=1e-9)
    np.testing.assert_allclose(mirrored.table, -plain.table, atol=SAME)
    np.testing.assert_allclose(mirrored.trajectory.poses, plain.trajectory.poses * [1, -1, -1], atol=SAME)


def test_a_reversed_start_finds_the_reversed_optimum(plain: Solution) -> None:
    back = optimum(begin()[::-1], FAR)
    assert back.cost == pytest.approx(plain.cost, abs=1e-9)
    apart = [np.abs(np.roll(plain.table[::-1], shift, axis=0) - back.table).max() for shift in range(12)]
    assert min(apart) < SAME  # a cycle may begin at any row


def test_size_and_weight_of_the_body_change_nothing(plain: Solution) -> None:
    scaled = "body.length_m=0.3", "body.weights=[5.0,10.0,10.0,10.0,5.0]"
    np.testing.assert_allclose(optimum(begin(), FAR, *scaled).table, plain.table, atol=SAME)


def test_a_mirrored_target_is_reached_by_the_mirrored_gait() -> None:
    left, right = (
        optimum(side * begin(), f"task.objectives=[{{kind='position',target=[0.3,{side * 0.1}],weight=5.0}}]")
        for side in (1, -1)
    )
    np.testing.assert_allclose(left.table, -right.table, atol=SAME)
