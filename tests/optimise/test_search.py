"""The derivative-free search comes close to certified optima and keeps the limits."""

from pathlib import Path

import numpy as np
import pytest

import serpenoid as sp
from serpenoid.gaits import EllipseGait
from serpenoid.mechanics.tables import joint_table
from serpenoid.optimise.search import search
from serpenoid.simulation import simulate_joint_angles

ROOT = Path(__file__).parents[2]
CERTIFIED = 0.612452  # problems/reference-optimum.toml: 99 of 100 random starts of the gait NLP


def test_search_comes_close_to_the_certified_optimum() -> None:
    problem = sp.load(ROOT / "problems" / "reference-optimum.toml")
    gait, cost = search(problem, [EllipseGait(sigma=0.6, a=5.0, xi=1.0), EllipseGait(sigma=1.0, a=6.0, xi=1.2)])
    assert -CERTIFIED - 1e-6 < cost < -0.98 * CERTIFIED
    table = joint_table(problem.model, gait.parameters, problem.task.steps)
    assert simulate_joint_angles(problem.model, table).displacement == pytest.approx(-cost, abs=1e-3)
    assert np.degrees(np.abs(table).max()) <= 60 + 1e-3
