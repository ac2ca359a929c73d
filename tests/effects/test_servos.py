"""Derivatives of realised joint angles, against differences."""

from __future__ import annotations

import numpy as np
import pytest

from effects.conftest import extended, place_of, typical
from serpenoid.effects import ActiveEffect, catalogue, find
from serpenoid.mechanics.servo import _one_by_one, memories, play
from serpenoid.problem import Problem
from serpenoid.simulation.sensitivity import servo_sensitivities
from serpenoid.simulation.servos import coordinates, realise

ACTUATION = [n for n, e in catalogue().items() if e.site == "actuation"]
TIMES = np.concatenate([np.arange(51) * 0.1, 5 + np.arange(1, 12) * 0.1])
STEP = 1e-6


@pytest.fixture(scope="module")
def setpoints(table: np.ndarray) -> np.ndarray:
    """One cycle and a pause."""
    return np.concatenate([table, np.repeat(table[:1], 12, axis=0)])


def changed(active: ActiveEffect, parameter: str, change: float) -> ActiveEffect:
    p = next(p for p in active.effect.parameters if p.name == parameter)
    values = active.parameters | {p.name: p.value(p.coordinate(active.parameters[p.name]) + change)}
    return ActiveEffect.model_construct(name=active.name, place=active.place, parameters=values)


@pytest.mark.parametrize("others", [(), ("servo_lag", "servo_delay"), ("speed_saturation", "backlash", "gain_loss")])
@pytest.mark.parametrize(("name", "parameter"), [(n, p.name) for n in ACTUATION for p in find(n).parameters])
@pytest.mark.parametrize("neutral", [True, False])
def test_derivatives_are_those_of_the_angles(
    name: str, parameter: str, others: tuple[str, ...], neutral: bool, problem: Problem, setpoints: np.ndarray
) -> None:
    if neutral and all(p.neutral is None for p in find(name).parameters):
        return  # a stuck joint is stuck at some angle
    if neutral and name == "servo_play":
        return  # a gap that is closed pushes neither way: fits begin with an open one (`starts`)
    active = ActiveEffect.neutral(name, place_of(name)) if neutral else typical(name)
    present = [typical(other) for other in others if other != name]
    model = extended(problem, *present, active)
    found = servo_sensitivities(model, setpoints, TIMES, [active] if neutral else [])
    (column,) = [i for i, c in enumerate(found.columns) if (c.effect, c.parameter) == (name, parameter)]
    high, low = (
        realise(extended(problem, *present, changed(active, parameter, h)), setpoints, TIMES) for h in (STEP, 0.0)
    )
    # a coordinate of 1 / speed has its kink far from zero; a row that begins or ends to slip within the step differs
    for exact, up, down in (
        (found.angles_by[..., column], high.angles, low.angles),
        (found.readings_by[..., column], high.readings, low.readings),
    ):
        difference = np.abs(exact - (up - down) / STEP)
        assert np.median(difference) < 1e-6
        assert (difference > 1e-4 * max(1.0, np.abs(exact).max())).mean() < 0.01
    # two exponentials: the C library's, and the polynomial of many joints at once
    np.testing.assert_allclose(found.angles, realise(model, setpoints, TIMES).angles, rtol=0, atol=1e-14)


def test_joints_side_by_side_are_those_one_after_the_other(problem: Problem, setpoints: np.ndarray) -> None:
    theta = coordinates(extended(problem, *(typical(name) for name in ACTUATION)))
    memory, durations = np.tile(setpoints[:1], (memories(), 1)), np.full(len(setpoints) - 1, 0.02)
    found = play(memory, setpoints, durations, theta)
    for lanes, columns in zip(found, _one_by_one(memory, setpoints, durations, theta), strict=True):
        np.testing.assert_allclose(lanes, columns, rtol=0, atol=1e-14)


def test_a_stuck_joint_is_no_candidate(problem: Problem, setpoints: np.ndarray) -> None:
    with pytest.raises(ValueError, match="put it into the model"):
        servo_sensitivities(extended(problem), setpoints, TIMES, [typical("stuck_joint")])


@pytest.mark.parametrize("name", ["servo_delay", "servo_lag", "servo_inertia", "speed_saturation", "backlash"])
def test_it_does_not_matter_into_how_many_rows_a_straight_line_is_cut(name: str, problem: Problem) -> None:
    # quick strokes there and back: a servo meets its set-point, and is left behind, inside of rows
    rows, times = np.array([0, 0.9, -1.1, 0.4, 0.5, -0.2, 1.3, 1.3]), np.array([0, 1, 1.7, 2.6, 4, 4.3, 6, 9.0])
    often = np.union1d(np.linspace(0, 9, 1000), times)
    model = extended(problem, ActiveEffect.typical(name, place_of(name)))
    coarse, fine = (
        realise(model, np.tile(np.interp(t, times, rows)[:, None], model.body.joint_count), t).angles
        for t in (times, often)
    )
    np.testing.assert_allclose(fine[np.searchsorted(often, times)], coarse, atol=1e-12, rtol=0)  # 1000 roundings
    assert np.abs(coarse[:, 2] - rows).max() > 0.01
