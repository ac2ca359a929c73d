"""Long bodies with many waves against the closed formulas of resistive force theory."""

from __future__ import annotations

import numpy as np
import pytest

from oracle.chain import serpenoid_joint_table
from oracle.resistive_force import sawtooth_angle, sawtooth_efficiency, serpenoid_displacement, wave_efficiency
from serpenoid.body import Body
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.simulation import simulate_joint_angles, simulate_vertices
from specimens import REFERENCE_EPS as EPS

pytestmark = pytest.mark.usefixtures("virtual_machine")


def wave_error(waves: int, dissipation: str, amplitude: float, per_wave: int = 48, eps: float = EPS) -> float:
    """Relative error of the displacement per cycle of a serpenoid wave, 100 steps; amplitude: largest angle [rad]."""
    bounds = None if eps <= 1 else (1.0, eps)
    medium = Medium(anisotropy_ratio=eps, anisotropy_ratio_bounds=bounds, dissipation=dissipation)
    model = Model(Body(vertices=per_wave * waves), medium)
    curvature = amplitude * 2 * np.pi * waves
    table = serpenoid_joint_table(model.body.edges, 100, sigma=1.0, a=curvature, xi=waves)
    motion = simulate_joint_angles(model, table)
    way = np.sign(motion.forward_displacement)
    return way * motion.displacement / serpenoid_displacement(eps, amplitude, waves) - 1


@pytest.mark.parametrize(("dissipation", "eps"), [("vertex", EPS), ("edge", EPS), ("vertex", 5.0), ("edge", 5.0)])
def test_a_long_wave_train_reaches_the_speed_of_an_infinite_one(dissipation: str, eps: float) -> None:
    """Where eps is above 1 that is backwards: the body moves the way its bends run."""
    eight, sixteen = (abs(wave_error(waves, dissipation, 0.5, eps=eps)) for waves in (8, 16))
    assert eight < 0.015
    assert sixteen < eight


def test_a_steep_wave_train_reaches_that_speed_as_the_chain_becomes_a_curve() -> None:
    # at one radian, 48 vertices per wave still add 0.3 %, against the ends' deficit: both within the bound, but their
    # sum says nothing about waves. The vertices' part is of order two, so extrapolation takes it out.
    fine, coarse = ([wave_error(waves, "vertex", 1.0, count) for waves in (8, 16)] for count in (48, 24))
    assert np.abs(fine).max() < 0.015
    eight, sixteen = np.abs((4 * np.array(fine) - coarse) / 3)
    assert sixteen < eight


def sawtooth(angle: float, waves: int, half: int) -> tuple[float, float]:
    """Displacement per cycle [waves] and efficiency of a travelling sawtooth with `half` edges on each straight side.

    The wave moves by one edge per step, so that corners always fall on vertices and every edge keeps its length.
    Edge dissipation: the tangents are those of the straight sides, without averaging over corners.
    """
    count = 2 * half * waves
    model = Model(Body(vertices=count + 1), Medium(anisotropy_ratio=EPS, dissipation="edge"))
    steps = 2 * half
    edge = np.arange(count)
    rise = np.array([np.where((edge - t) // half % 2 == 0, 1, -1) for t in range(steps + 1)])
    direction = np.stack([np.full(rise.shape, np.cos(angle)), rise * np.sin(angle)], axis=-1) / count
    shapes = np.concatenate([np.zeros((steps + 1, 1, 2)), np.cumsum(direction, axis=1)], axis=1)
    motion = simulate_vertices(model, shapes)
    # one cycle lasts one unit of time: speed = displacement, mean power = sum of 2 E / dt
    power = 2 * motion.step_energy.sum() * steps
    return motion.displacement * waves, EPS * motion.displacement**2 / power


def efficiency(angle: float, waves: int) -> float:
    """Efficiency with infinitely many edges per side: the edge that turns a corner jumps, an error of order one."""
    coarse, fine = (sawtooth(angle, waves, half)[1] for half in (12, 24))
    return 2 * fine - coarse


def test_lighthills_sawtooth_efficiency_is_approached_with_the_number_of_waves() -> None:
    errors = [abs(efficiency(sawtooth_angle(EPS), waves) / sawtooth_efficiency(EPS) - 1) for waves in (4, 8)]
    assert errors[1] < errors[0]
    assert errors[1] < 0.01  # the ends of eight waves


def test_lighthills_angle_is_the_best_one() -> None:
    angles = sawtooth_angle(EPS) + np.array([-0.1, 0.0, 0.1])
    a, b, _ = np.polyfit(angles, [efficiency(angle, 8) for angle in angles], 2)
    assert a < 0
    assert -b / (2 * a) == pytest.approx(sawtooth_angle(EPS), abs=0.02)  # ends and the parabola: a degree


def test_infinite_wave_formulas_agree_with_each_other_on_lighthills_sawtooth() -> None:
    angle = sawtooth_angle(EPS)
    expected = wave_efficiency(EPS, np.cos(angle) ** 2, np.cos(angle))
    assert sawtooth_efficiency(EPS) == pytest.approx(expected, rel=1e-12)
