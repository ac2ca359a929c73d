"""Purcell's three-link swimmer: what a small loop in its two joints is worth."""

from __future__ import annotations

import numpy as np
import pytest

from oracle.integrator import simulate
from serpenoid.body import Body
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.simulation import simulate_joint_angles

EDGES = 8  # of each link


def circle(radius: float, steps: int = 64) -> np.ndarray:
    phase = 2 * np.pi * np.arange(steps) / steps
    return radius * np.stack([np.cos(phase), np.sin(phase)], axis=1)


def worth(ratio: float, edges: int) -> float:
    """Displacement along the body over the area of a small loop about the straight body [body lengths per rad^2]."""
    medium = Medium(anisotropy_ratio=1 / ratio, dissipation="edge")
    model = Model(Body(vertices=3 * edges + 1, joints=(edges, 2 * edges)), medium)
    table = circle(0.02)
    area = np.pi * 0.02**2 * np.sin(2 * np.pi / 64) / (2 * np.pi / 64)  # of the polygon
    return simulate_joint_angles(model, table).forward_displacement / area


@pytest.mark.parametrize("ratio", [1.5, 2.0, 4.0])
def test_a_small_loop_moves_the_swimmer_by_five_243rds_of_the_drag_ratio_less_one_times_its_area(ratio: float) -> None:
    coarse, fine = worth(ratio, EDGES), worth(ratio, 2 * EDGES)
    limit = (4 * fine - coarse) / 3  # a link of n edges has its rotational drag to 1 / n^2
    # terms of fourth order in the angles: 0.02^2
    assert abs(limit) == pytest.approx(5 / 243 * (ratio - 1), rel=2e-3)


def test_the_independent_simulator_agrees_on_the_loop() -> None:
    n, table = 12, circle(0.3, 32)
    model = Model(Body(vertices=n + 1, joints=(4, 8)), Medium(anisotropy_ratio=0.5, dissipation="edge"))
    run = simulate(table, np.ones(n), model.body.vertex_weights, 0.5, dissipation="edge", joints=(4, 8))
    np.testing.assert_allclose(simulate_joint_angles(model, table).poses, run.poses, atol=1e-9)
