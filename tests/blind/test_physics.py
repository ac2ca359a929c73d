"""The generator against physics: what is known before any robot moves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from blind.ground import Ground, Patch
from blind.motion import Drive, paths
from blind.schedule import Plan, Servos, grid, realise
from blind.snake import EDGES, WEIGHTS, Floats
from oracle.chain import serpenoid_joint_table
from oracle.integrator import simulate

EPS = 0.2
TABLE = serpenoid_joint_table(EDGES, 50, sigma=0.8, a=5.5, xi=1.1, x_c=0.8, theta=0.4)
NULL = Ground(EPS)


def drive(
    table: Floats = TABLE, cycle_s: float = 4.0, pause_s: float = 1.0, steps: int = 1000, **servos: float
) -> Drive:
    g = grid(Plan(table, cycle_s, pause_s, 1), steps)
    return Drive(g.time, realise(g, Servos(**servos))[0], g.phase, np.array([0.1, -0.2, 0.3]))


def path(ground: Ground, **kwargs: object) -> Floats:
    return paths(ground, [drive(**kwargs)])[0]  # type: ignore[arg-type]


MODERATE = {
    "worn_wheel": {"seizure": {4: 0.5}},
    "load": {"share": {3: 0.1}},
    "dry_friction": {"crossover_speed": 0.05},
    "grip_saturation": {"saturation_speed": 0.1},
    "forward_backward_asymmetry": {"forward_backward": 0.3},
    "left_right_asymmetry": {"left_right": 0.3},
    "toe": {"toe": 0.05},
    "slope": {"pull": (0.003, 0.002)},
    "friction_patch": {"patches": (Patch(2.0, 0.2, 0.1, 0.2),)},
    "friction_gradient": {"gradient": (0.5, 0.5)},
    "anisotropy_drift": {"drift_rate": 0.05},
    "power_law_drag": {"exponent": 0.6},
    "inertia": {"inertia": 0.1},
    "added_mass": {"added_mass": 0.2},
    "contact_offset": {"contact_offset": 0.018},
}
ZERO = {
    "worn_wheel": {"seizure": {4: 0.0}},
    "load": {"share": {3: 0.0}},
    "grip_saturation": {"saturation_speed": 1e12},
    "friction_patch": {"patches": (Patch(0.0, 0.2, 0.1, 0.2),)},
    "power_law_drag": {"exponent": 1.0},
}


def test_null_is_the_limit_of_the_papers_integrator_and_both_are_of_order_two() -> None:
    """Refined tables of the oracle approach the generator's path with the square of the step."""
    length = EDGES.sum()
    best = paths(NULL, [replace(drive(pause_s=0.0, steps=4000), start=np.zeros(3))])[0][-1]
    errors = []
    for n in (100, 200):
        rows = grid(Plan(TABLE, 4.0, 0.0, 1), n).setpoint[:-1]
        errors.append(np.abs(simulate(rows, EDGES, WEIGHTS, EPS).poses[-1] * [length, length, 1] - best).max())
    assert errors[0] / errors[1] == pytest.approx(4, abs=0.2)
    assert errors[1] < 1e-4  # m and rad
    own = [
        np.abs(paths(NULL, [replace(drive(pause_s=0.0, steps=n), start=np.zeros(3))])[0][-1] - best).max()
        for n in (250, 500)
    ]
    assert own[0] / own[1] == pytest.approx(4, abs=0.4)


def test_a_scallop_does_not_move() -> None:
    there = TABLE[:26]
    back = np.concatenate([there, there[-2:0:-1]])
    p = path(NULL, table=back)
    np.testing.assert_allclose(p[-1], p[0], atol=1e-12)


def test_mirrored_shapes_mirror_the_path() -> None:
    centre = replace(drive(), start=np.zeros(3))
    mirrored = replace(drive(-TABLE), start=np.zeros(3))
    a, b = paths(NULL, [centre, mirrored])
    np.testing.assert_allclose(a * [1, -1, -1], b, atol=1e-12)


@pytest.mark.parametrize("name", ["dry_friction", "power_law_drag", "grip_saturation", "inertia", "added_mass"])
def test_these_effects_do_not_know_left_from_right(name: str) -> None:
    ground = replace(NULL, **MODERATE[name])
    a, b = paths(ground, [replace(drive(s * TABLE), start=np.zeros(3)) for s in (1, -1)])
    np.testing.assert_allclose(a * [1, -1, -1], b, atol=1e-8)


def test_left_right_asymmetry_changes_its_sign_in_the_mirror() -> None:
    grounds = [replace(NULL, left_right=s) for s in (0.3, -0.3)]
    a, b = (paths(g, [replace(drive(s * TABLE), start=np.zeros(3))])[0] for g, s in zip(grounds, (1, -1), strict=True))
    np.testing.assert_allclose(a * [1, -1, -1], b, atol=1e-8)


def test_speed_is_invisible_to_homogeneous_laws_only() -> None:
    for law in ({}, {"exponent": 0.6}):
        quick, slow = (path(replace(NULL, **law), cycle_s=s)[-1] for s in (2.0, 8.0))
        np.testing.assert_allclose(quick, slow, atol=2e-3 if law else 1e-12)  # creep speed softens the power law
    quick, slow = (path(replace(NULL, crossover_speed=0.05), cycle_s=s)[-1] for s in (2.0, 8.0))
    assert np.abs(quick - slow).max() > 2e-3


@pytest.mark.parametrize("name", ZERO)
def test_zero_strength_is_the_null(name: str) -> None:
    np.testing.assert_allclose(path(replace(NULL, **ZERO[name])), path(NULL), atol=1e-8)


@pytest.mark.parametrize("name", MODERATE)
def test_moderate_strength_changes_the_path(name: str) -> None:
    assert np.abs(path(replace(NULL, **MODERATE[name])) - path(NULL))[:, :2].max() > 1e-3


@pytest.mark.parametrize("law", [{}, {"crossover_speed": 0.05}])
def test_vanishing_inertia_approaches_the_massless_body(law: dict[str, float]) -> None:
    massless = replace(NULL, **law)
    errors = [np.abs(path(replace(massless, inertia=m)) - path(massless)).max() for m in (0.04, 0.02, 0.01)]
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 5e-3


def test_inertia_is_integrated_with_order_two() -> None:
    ground = replace(NULL, inertia=0.3)
    ends = [path(ground, steps=n)[-1] for n in (250, 500, 1000)]
    ratio = np.abs(ends[1] - ends[0]).max() / np.abs(ends[2] - ends[1]).max()
    assert ratio == pytest.approx(4, abs=1)  # the schedule's sudden starts disturb the order a little


def test_a_pushed_body_without_shape_change_obeys_newton() -> None:
    """Constant pull p, isotropic drag: x = p (t - tau (1 - exp(-t / tau)))."""
    still = np.tile(TABLE[:1], (50, 1))
    ground = Ground(1.0, inertia=0.5, pull=(0.01, 0.0))
    d = drive(still)
    x = paths(ground, [d])[0][:, 0] - d.start[0]
    np.testing.assert_allclose(x, 0.01 * (d.time - 0.5 * (1 - np.exp(-d.time / 0.5))), atol=1e-7)


def test_an_isotropic_body_on_a_slope_slides_at_the_pull_speed() -> None:
    d = drive()
    p = paths(Ground(1.0, pull=(0.002, -0.001)), [d])[0]
    np.testing.assert_allclose(p[:, :2] - d.start[:2], d.time[:, None] * [0.002, -0.001], atol=1e-9)


@pytest.mark.parametrize(
    "servos",
    [
        {"lag": 0.05},
        {"max_speed": 0.4},
        {"width": {3: 0.05}},
        {"loss": {5: 0.2}},
        {"stuck": {2: 0.1}},
        {"offset": {7: 0.05}},
    ],
)
def test_actuation_effects_change_the_shape(servos: dict) -> None:  # type: ignore[type-arg]
    g = grid(Plan(TABLE, 4.0, 1.0, 1))
    true, reading = realise(g, Servos(**servos))
    assert np.abs(true - g.setpoint).max() > 0.01
    assert (np.abs(reading - true).max() > 0.01) == ("offset" in servos)


def test_lag_follows_its_differential_equation() -> None:
    g = grid(Plan(TABLE, 4.0, 1.0, 1))
    q, _ = realise(g, Servos(lag=0.1))
    h = np.diff(g.time)[:, None]
    middle = lambda a: (a[1:] + a[:-1]) / 2  # noqa: E731
    np.testing.assert_allclose(np.diff(q, axis=0) / h, middle(g.setpoint - q) / 0.1, atol=1e-3)
