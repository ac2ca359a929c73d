"""What is known about each effect without any simulation."""

from __future__ import annotations

import numpy as np
import pytest

import serpenoid as sp
from effects.conftest import extended, typical
from serpenoid.body import Body
from serpenoid.effects import ActiveEffect, catalogue, find
from serpenoid.media import LAWS
from serpenoid.model import Model
from serpenoid.problem import Problem
from serpenoid.trajectory import Trajectory

MEDIUM = [name for name, effect in catalogue().items() if effect.site == "medium"]
KNOW_SIDES = {"left_right_asymmetry", "toe", "slope", "friction_patch", "friction_gradient"}
HOMOGENEOUS = [
    "worn_wheel",
    "rough_skin",
    "load",
    "toe",
    "contact_offset",
    "track_width",
    "wheel_mount",
    "friction_patch",
    "friction_gradient",
]
KNOW_SPEED = [
    "dry_friction",
    "rolling_resistance",
    "grip_saturation",
    "slope",
    "inertia",
    "added_mass",
    "anisotropy_drift",
]
MIRROR = np.array([1, -1, -1])


def played(model: Model, table: np.ndarray, **kwargs: object) -> Trajectory:
    motion = sp.simulate_joint_angles(model, table, **kwargs)  # type: ignore[arg-type]
    assert motion.status.ok
    return motion


def net(motion: Trajectory) -> np.ndarray:
    return motion.poses[-1] - motion.poses[0]


@pytest.mark.parametrize("name", sorted(set(MEDIUM) - KNOW_SIDES))
def test_effects_that_do_not_know_sides_commute_with_the_mirror(name: str, problem: Problem, table: np.ndarray) -> None:
    model = extended(problem, typical(name))
    left, right = (played(model, sign * table) for sign in (1, -1))
    np.testing.assert_allclose(left.poses * MIRROR, right.poses, atol=1e-10)


@pytest.mark.parametrize(("name", "parameter"), [("left_right_asymmetry", "asymmetry"), ("toe", "angle")])
def test_effects_that_know_sides_change_their_sign_in_the_mirror(
    name: str, parameter: str, problem: Problem, table: np.ndarray
) -> None:
    left, right = (
        played(extended(problem, ActiveEffect.of(name, **{parameter: sign * 0.2})), sign * table) for sign in (1, -1)
    )
    np.testing.assert_allclose(left.poses * MIRROR, right.poses, atol=1e-10)
    same = played(extended(problem, ActiveEffect.of(name, **{parameter: 0.2})), -table)
    assert np.abs(same.poses - right.poses).max() > 1e-3


@pytest.mark.parametrize("name", HOMOGENEOUS)
def test_homogeneous_laws_are_blind_to_speed(name: str, problem: Problem, table: np.ndarray) -> None:
    quick, slow = (played(extended(problem, typical(name), duration=s), table) for s in (2.0, 8.0))
    np.testing.assert_allclose(quick.poses, slow.poses, atol=1e-10)


@pytest.mark.parametrize("name", KNOW_SPEED)
def test_mixtures_of_laws_know_speed(name: str, problem: Problem, table: np.ndarray) -> None:
    quick, slow = (played(extended(problem, typical(name), duration=s), table) for s in (2.0, 8.0))
    assert np.abs(quick.poses - slow.poses)[:, :2].max() > 2e-3


LONGER, SLOWER = 1.7, 2.3  # every length, every time
CREEPING = {
    "dry_friction",
    "forward_backward_asymmetry",
    "left_right_asymmetry",
    "power_law_drag",
    "rolling_resistance",
}
ACTING = [(name, law) for name in MEDIUM for law in LAWS if find(name).acts_in(law)]


def in_other_sizes(unit: str) -> float:
    """By how much a quantity in this unit grows with lengths and times."""
    sizes = {"m": LONGER, "m2": LONGER**2, "s": SLOWER, "s2": SLOWER**2}
    over, *under = (sizes.get(part, 1.0) for part in unit.split("/"))
    return over / float(np.prod(under))


@pytest.mark.parametrize(("name", "law"), ACTING)
def test_units_are_those_that_leave_a_larger_and_slower_robot_the_same_motion(
    name: str, law: str, problem: Problem, table: np.ndarray
) -> None:
    effect = typical(name)
    units = {p.name: p.unit_in(LAWS[law]) for p in effect.effect.parameters}
    values = {name: value * in_other_sizes(units[name]) for name, value in effect.parameters.items()}
    medium = problem.medium.model_copy(update={"law": law})
    small = Model(problem.body, medium, (effect,), 5.0)
    longer = {"edge_lengths": [LONGER * edge for edge in problem.body.edges_m]}
    body = Body.model_validate(problem.body.model_dump() | longer)
    large = Model(body, medium, (ActiveEffect.of(name, effect.place, **values),), SLOWER * 5.0)
    assert large.body.total_length_m == pytest.approx(LONGER * small.body.total_length_m)
    near = 4e-4 if name in CREEPING else 1e-10  # 1 mm/s is another share of other speeds
    np.testing.assert_allclose(played(large, table).poses, played(small, table).poses, atol=near)


@pytest.mark.parametrize("name", ["slope", "inertia"])
def test_a_body_twice_as_heavy_everywhere_moves_alike(name: str, problem: Problem, table: np.ndarray) -> None:
    light = extended(problem, typical(name), duration=4.0)
    weights = light.body.vertex_weights
    loads = [ActiveEffect.of("load", k, share=float(w)) for k, w in enumerate(weights)]
    heavy = extended(problem, typical(name), *loads, duration=4.0)
    np.testing.assert_allclose(played(heavy, table).poses, played(light, table).poses, atol=1e-10)


def test_a_power_law_is_blind_to_speed_but_for_the_creep(problem: Problem, table: np.ndarray) -> None:
    quick, slow = (played(extended(problem, typical("power_law_drag"), duration=s), table) for s in (2.0, 8.0))
    assert np.abs(quick.poses - slow.poses).max() < 2e-3


def test_an_isotropic_body_on_a_slope_slides_downhill_at_the_pull_speed(problem: Problem, table: np.ndarray) -> None:
    body, medium = problem.body, problem.medium.model_copy(update={"anisotropy_ratio": 1.0})
    model = Model(body, medium, (ActiveEffect.of("slope", pull_x=0.002, pull_y=-0.001),), 5.0)
    still = Model(body, medium, (), 5.0)
    slid = played(model, table).poses - played(still, table).poses
    expected = np.linspace(0, 5, 51)[:, None] * [0.002, -0.001] / body.total_length_m
    np.testing.assert_allclose(slid[:, :2], expected, atol=1e-12)


def test_a_body_that_does_not_bend_relaxes_to_the_pull_speed_as_newton_says(problem: Problem) -> None:
    """x = p (t - tau (1 - exp(-t / tau))) for isotropic drag, from rest; order two in the step."""
    pull, tau = 0.01, 0.5
    medium = problem.medium.model_copy(update={"anisotropy_ratio": 1.0})
    effects = (ActiveEffect.of("slope", pull_x=pull, pull_y=0.0), ActiveEffect.of("inertia", relaxation_time=tau))
    model = Model(problem.body, medium, effects)
    errors = []
    for steps in (100, 200):
        times = np.linspace(0, 2, steps + 1)
        motion = sp.simulate_realised(model, np.zeros((steps + 1, 10)), times)
        exact = pull * (times - tau * (1 - np.exp(-times / tau))) / problem.body.total_length_m
        errors.append(np.abs(motion.poses[:, 0] - exact).max())
    assert errors[0] / errors[1] == pytest.approx(4, abs=0.5)


@pytest.mark.parametrize("name", ["inertia", "added_mass"])
def test_vanishing_inertia_approaches_the_massless_body(name: str, problem: Problem, table: np.ndarray) -> None:
    baseline = played(extended(problem), table).poses
    errors = [
        np.abs(played(extended(problem, ActiveEffect.of(name, relaxation_time=s)), table).poses - baseline).max()
        for s in (0.04, 0.02, 0.01, 1e-9)
    ]
    assert errors[0] > errors[1] > errors[2] > errors[3]
    assert errors[3] < 1e-8


def test_a_seized_chain_is_isotropic_and_stays_where_it_is(problem: Problem, table: np.ndarray) -> None:
    """All wheels seized = eps 1: equal drag everywhere keeps the weighted centroid in place."""
    effects = [ActiveEffect.of("worn_wheel", k, seizure=1.0) for k in range(12)]
    motion = played(extended(problem, *effects), table)
    np.testing.assert_allclose(motion.poses[:, :2], 0, atol=1e-12)


def test_skin_that_is_as_rough_everywhere_is_another_anisotropy_ratio(problem: Problem, table: np.ndarray) -> None:
    rough = extended(problem, *(ActiveEffect.of("rough_skin", k, roughness=0.6) for k in range(12)))
    medium = problem.medium.model_copy(update={"anisotropy_ratio": 1.6 * problem.medium.anisotropy_ratio})
    other = Model(problem.body, medium, (), 5.0)
    np.testing.assert_allclose(played(rough, table).poses, played(other, table).poses, atol=1e-10)


@pytest.mark.parametrize("ratio", [0.1, 0.9])
def test_in_linear_drag_a_rough_skin_resists_as_a_worn_wheel(ratio: float, problem: Problem, table: np.ndarray) -> None:
    """eps (1 + roughness) = eps + seizure (1 - eps)."""
    seizure = 0.4
    medium = problem.medium.model_copy(update={"anisotropy_ratio": ratio})
    effects = [
        ActiveEffect.of("worn_wheel", 4, seizure=seizure),
        ActiveEffect.of("rough_skin", 4, roughness=seizure * (1 - ratio) / ratio),
    ]
    wheel, skin = (played(Model(problem.body, medium, (e,), 5.0), table).poses for e in effects)
    np.testing.assert_allclose(skin, wheel, atol=1e-10)


def test_skin_that_rubs_along_as_across_can_be_rough_or_smooth_at_a_vertex(problem: Problem, table: np.ndarray) -> None:
    """Where a seizure says nothing, the ratio being one: a body that stays where it is moves, to either side."""
    medium = problem.medium.model_copy(update={"anisotropy_ratio": 1.0})
    none, rough, smooth = (
        net(played(Model(problem.body, medium, (ActiveEffect.of("rough_skin", 4, roughness=r),), 5.0), table))
        for r in (0.0, 0.1, -0.1)
    )
    np.testing.assert_allclose(none[:2], 0, atol=1e-12)
    np.testing.assert_allclose(rough - none, none - smooth, rtol=0.2)  # but for what grows with the square
    assert np.abs(rough[:2]).max() > 1e-4


def test_a_patch_wider_than_the_arena_changes_nothing_but_the_drag_level(problem: Problem, table: np.ndarray) -> None:
    wide = ActiveEffect.of("friction_patch", strength=3.0, x=0.0, y=0.0, radius=10.0)
    np.testing.assert_allclose(
        played(extended(problem, wide), table).poses, played(extended(problem), table).poses, atol=2e-3
    )


@pytest.mark.parametrize("name", ["slope", "friction_patch", "friction_gradient"])
def test_place_matters_for_effects_of_the_floor(name: str, problem: Problem, table: np.ndarray) -> None:
    model = extended(problem, typical(name))
    here = played(model, table)
    there = played(model, table, start=np.array([0.3, 0.2, 2.0]))
    assert np.abs(here.net_motion - there.net_motion).max() > 1e-3


def test_friction_only_takes_energy(problem: Problem, table: np.ndarray) -> None:
    for name in MEDIUM:
        assert (played(extended(problem, typical(name)), table).step_energy >= 0).all(), name


def test_lag_delays_and_shrinks_a_sine_as_a_first_order_filter(problem: Problem) -> None:
    """Amplitude 1 / sqrt(1 + (omega lag)^2), delay atan(omega lag), for finely sampled set-points."""
    from serpenoid.simulation.servos import realise_gait

    lag, cycle = 0.3, 5.0
    phase = 2 * np.pi * np.arange(2000) / 2000
    table = np.repeat(np.sin(phase)[:, None], 10, axis=1)
    found = realise_gait(extended(problem, ActiveEffect.of("servo_lag", lag=lag), duration=cycle), table)
    omega = 2 * np.pi / cycle
    expected = np.sin(phase - np.arctan(omega * lag)) / np.hypot(1, omega * lag)
    np.testing.assert_allclose(found[:, 0], expected, atol=1e-5)
