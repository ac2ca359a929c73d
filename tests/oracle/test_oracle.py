"""The oracle against closed formulas and symmetries: it must stand on its own before it judges anything."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from oracle.chain import Floats, serpenoid_joint_table
from oracle.integrator import REFERENCE, simulate
from oracle.resistive_force import sawtooth_angle, sawtooth_efficiency, serpenoid_displacement, wave_efficiency
from oracle.search import REFERENCE_BOUNDS, global_search, polish
from oracle.small_strokes import cheapest_stroke

EDGES, WEIGHTS, EPS = np.ones(11), np.ones(12), 0.1865


def table(steps: int = 20, **changes: float) -> Floats:
    return serpenoid_joint_table(EDGES, steps, **{**REFERENCE, **changes})


def test_reference_gait_moves_head_first() -> None:
    run = simulate(table(50), EDGES, WEIGHTS, EPS)
    assert run.forward_displacement > 0.4
    assert abs(run.poses[-1, 2]) < 1e-9  # half a turn of theta mirrors the circle gait


def test_order_two_in_time() -> None:
    d = [simulate(table(n, sigma=0.7, x_c=1.0), EDGES, WEIGHTS, EPS).displacement for n in (25, 50, 100)]
    assert (d[1] - d[0]) / (d[2] - d[1]) == pytest.approx(4, abs=0.1)


def test_isotropic_drag_moves_no_centroid() -> None:
    poses = simulate(table(sigma=0.6, y_c=2.0), EDGES, np.arange(1, 13), 1.0).poses
    assert np.abs(poses[:, :2]).max() < 1e-11


@pytest.mark.parametrize("dissipation", ["vertex", "edge"])
def test_scallop_returns(dissipation: str) -> None:
    open_path = table(sigma=0.6, y_c=2.0)
    there_and_back = np.concatenate([open_path, open_path[-2::-1]])
    run = simulate(there_and_back, EDGES, WEIGHTS, EPS, dissipation=dissipation, closed=False)
    assert np.abs(run.poses[-1]).max() < 1e-10


def test_mirrored_shapes_mirror_the_motion() -> None:
    shapes = table(sigma=0.6, y_c=2.0)
    a, b = simulate(shapes, EDGES, WEIGHTS, EPS).poses, simulate(-shapes, EDGES, WEIGHTS, EPS).poses
    np.testing.assert_allclose(a * [1, -1, -1], b, atol=1e-11)


def test_start_pose_moves_the_whole_path() -> None:
    shapes = table(sigma=0.6, y_c=2.0)
    a = simulate(shapes, EDGES, WEIGHTS, EPS)
    b = simulate(shapes, EDGES, WEIGHTS, EPS, start_pose=(30.0, -7.0, 2.0))
    np.testing.assert_allclose(b.energies, a.energies, rtol=1e-10)
    assert b.displacement == pytest.approx(a.displacement, abs=1e-11)


def test_long_wave_train_reaches_the_resistive_force_speed() -> None:
    waves, amplitude = 8, 1.0
    n = 24 * waves
    shapes = serpenoid_joint_table(np.ones(n), 60, sigma=1.0, a=amplitude * 2 * np.pi * waves, xi=waves)
    run = simulate(shapes[:16], np.ones(n), np.ones(n + 1), EPS, closed=False)
    # 15 of 60 steps; by symmetry a quarter of the cycle is a quarter of the way, up to end effects
    expected = serpenoid_displacement(EPS, amplitude, waves) / 4
    assert run.displacement == pytest.approx(expected, rel=0.05)


def test_lighthills_sawtooth_is_the_best_one() -> None:
    best = minimize_scalar(
        lambda t: -wave_efficiency(EPS, np.cos(t) ** 2, np.cos(t)), bounds=(0.1, 1.4), method="bounded"
    )
    assert best.x == pytest.approx(sawtooth_angle(EPS), abs=1e-4)
    assert -best.fun == pytest.approx(sawtooth_efficiency(EPS), rel=1e-8)


def test_search_finds_a_known_minimum_on_a_bound() -> None:
    def cost(gait: dict[str, float]) -> float:
        return (
            (gait["sigma"] - 2) ** 2
            + (gait["a"] - 5) ** 2
            + sum(gait[n] ** 2 for n in ("x_c", "y_c", "theta"))
            + gait["xi"]
        )

    found = global_search(cost, REFERENCE_BOUNDS, seed=1, generations=60)
    assert found.gait["sigma"] == pytest.approx(1, abs=1e-4)
    assert found.cost == pytest.approx(1.5, abs=1e-3)
    assert polish(cost, found.gait).cost <= found.cost + 1e-12


def test_the_cheapest_small_stroke_of_five_links_is_a_wave_three_links_long() -> None:
    """Joints that follow each other by a third of a cycle (Alouges et al. 2019); edge effects: a few degrees."""
    np.testing.assert_allclose(cheapest_stroke(links=5, per_link=4, eps=0.5).lags, 120, atol=5)
