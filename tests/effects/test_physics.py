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
from serpenoid.simulation.servos import realise, realise_gait
from serpenoid.trajectory import Trajectory

MEDIUM = [name for name, effect in catalogue().items() if effect.site == "medium"]
KNOW_SIDES = {"left_right_asymmetry", "toe", "slope", "friction_patch", "grip_patch", "friction_gradient"}
HOMOGENEOUS = [
    "worn_wheel",
    "rough_skin",
    "load",
    "toe",
    "contact_offset",
    "track_width",
    "wheel_mount",
    "tyre_grip",
    "friction_patch",
    "grip_patch",
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
DEAR = "coulomb_plain", "coulomb_by_components"  # softened and in the units of `coulomb`, which is always tried
ACTING = [
    pytest.param(name, law, marks=pytest.mark.slow if law in DEAR else [])
    for name in MEDIUM
    for law in LAWS
    if find(name).acts_in(law)
]


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


@pytest.mark.parametrize("name", ["slope", "friction_patch", "grip_patch", "friction_gradient"])
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
    lag, cycle = 0.3, 5.0
    phase = 2 * np.pi * np.arange(2000) / 2000
    table = np.repeat(np.sin(phase)[:, None], 10, axis=1)
    found = realise_gait(extended(problem, ActiveEffect.of("servo_lag", lag=lag), duration=cycle), table)
    omega = 2 * np.pi / cycle
    expected = np.sin(phase - np.arctan(omega * lag)) / np.hypot(1, omega * lag)
    np.testing.assert_allclose(found[:, 0], expected, atol=1e-5)


def servos(problem: Problem, setpoints: np.ndarray, times: np.ndarray, name: str, **values: float) -> np.ndarray:
    """Angles (R,) of one joint of the robot's, all told the same (R,)."""
    model = extended(problem, ActiveEffect.of(name, **values))
    return realise(model, np.repeat(setpoints[:, None], 10, axis=1), times).angles[:, 0]


@pytest.mark.parametrize("delay", [0.003, 0.06, 0.41, 4.9])
def test_servos_that_are_late_do_all_they_are_told_so_much_later(delay: float, problem: Problem) -> None:
    """Corners between rows and all, from rest on the first row; what is told last is not done in time."""
    rows, corners = np.array([0.2, 0.9, -1.1, 0.4, 0.5, -0.2, 1.3, 1.3]), np.array([0, 1, 1.7, 2.6, 4, 4.3, 6, 9.0])
    found = servos(problem, rows, corners, "servo_delay", delay=delay)
    np.testing.assert_allclose(found, np.interp(corners - delay, corners, rows), rtol=0, atol=1e-14)


def test_a_lag_after_a_delay_follows_a_ramp_that_began_so_much_later(problem: Problem) -> None:
    """q = s (t - delay - lag (1 - exp(-(t - delay) / lag))), and 0 before: times that meet no row of the command."""
    delay, lag, rate = 0.13, 0.3, 0.7
    times = np.linspace(0, 2, 41)
    late = ActiveEffect.of("servo_delay", delay=delay), ActiveEffect.of("servo_lag", lag=lag)
    found = realise(extended(problem, *late), np.repeat(rate * times[:, None], 10, axis=1), times)
    since = np.maximum(times - delay, 0.0)
    expected = rate * (since - lag * (1 - np.exp(-since / lag)))
    np.testing.assert_allclose(found.angles[:, 0], expected, rtol=0, atol=1e-12)  # the law's own floor of a lag
    np.testing.assert_array_equal(found.readings, found.angles)


@pytest.mark.parametrize("delay", [0.0004, 0.25, 4.9])  # less than a row, rows and a part, more than a cycle
def test_a_gait_of_servos_that_are_late_is_the_gait_so_much_later(delay: float, problem: Problem) -> None:
    """For finely sampled set-points; a delay of whole rows moves them, to the last bit."""
    cycle, count = 4.0, 4000
    phase = 2 * np.pi * np.arange(count) / count
    table = np.repeat(np.sin(phase)[:, None], 10, axis=1)
    found, whole = (
        realise_gait(extended(problem, ActiveEffect.of("servo_delay", delay=d), duration=cycle), table)
        for d in (delay, cycle / 4)
    )
    np.testing.assert_allclose(found[:, 0], np.sin(phase - 2 * np.pi * delay / cycle), rtol=0, atol=1e-6)
    np.testing.assert_array_equal(whole, np.roll(table, count // 4, axis=0))


@pytest.mark.parametrize("damping", [0.2, 0.7, 1.0, 1.3, 5.0])
def test_servos_with_inertia_answer_a_sine_as_a_filter_of_second_order(damping: float, problem: Problem) -> None:
    """By the factor 1 / (1 - (omega / w)^2 + i omega lag), w = 2 damping / lag, for finely sampled set-points."""
    lag, cycle = 0.4, 5.0
    phase = 2 * np.pi * np.arange(4000) / 4000
    table = np.repeat(np.sin(phase)[:, None], 10, axis=1)
    moved = ActiveEffect.of("servo_inertia", lag=lag, damping=damping)
    found = realise_gait(extended(problem, moved, duration=cycle), table)
    omega = 2 * np.pi / cycle
    factor = 1 / (1 - (omega * lag / (2 * damping)) ** 2 + 1j * omega * lag)
    np.testing.assert_allclose(found[:, 0], (factor * np.exp(1j * phase)).imag, atol=1e-5)


@pytest.mark.parametrize("damping", [0.1, 0.5, 0.9])
def test_servos_with_inertia_overshoot_a_jump_by_what_their_damping_says(damping: float, problem: Problem) -> None:
    """exp(-pi damping / sqrt(1 - damping^2)), half a period after the jump (textbooks of control)."""
    lag, root = 0.1, np.sqrt(1 - damping**2)
    peak = np.pi * lag / (2 * damping * root)
    times = np.array([0.0, 1e-9, peak, 2 * peak])
    found = servos(problem, np.array([0.0, 1.0, 1.0, 1.0]), times, "servo_inertia", lag=lag, damping=damping)
    over = np.exp(-np.pi * damping / root)
    np.testing.assert_allclose(found[2:], [1 + over, 1 - over**2], atol=1e-7)  # a jump takes a nanosecond


def test_two_lags_one_after_the_other_are_inertia_that_creeps(problem: Problem) -> None:
    """(1 + a s)(1 + b s): lag a + b, damping (a + b) / (2 sqrt(a b)), whatever is told."""
    a, b = 0.05, 0.2
    times = np.linspace(0, 3, 3001)
    told = np.sin(7 * times) * np.exp(-times)
    model = extended(problem, ActiveEffect.of("servo_lag", lag=a), ActiveEffect.of("lagging_joint", 1, lag=b))
    chain = realise(model, np.repeat(told[:, None], 10, axis=1), times).angles[:, 0]
    both = servos(problem, told, times, "servo_inertia", lag=a + b, damping=(a + b) / (2 * np.sqrt(a * b)))
    np.testing.assert_allclose(both, chain, atol=2e-6)  # what passes from lag to lag is taken to be straight in a step


def test_critical_damping_is_no_corner(problem: Problem) -> None:
    """A servo neither side of which another formula is used moves as its neighbours do."""
    rng = np.random.default_rng(0)
    times, told = np.cumsum(rng.uniform(0.01, 0.3, 40)), rng.normal(size=40)
    apart = 1e-6
    below, at, above = (
        servos(problem, told, times, "servo_inertia", lag=0.1, damping=1 + n * apart) for n in (-1, 0, 1)
    )
    assert np.abs(above - below).max() < 10 * apart
    np.testing.assert_allclose(at, (above + below) / 2, atol=1e-10)  # the second difference, and rounding


def test_the_more_damped_inertia_is_the_nearer_it_comes_to_a_lag(problem: Problem) -> None:
    """With lag held, by the square of the damping ratio."""
    times = np.linspace(0, 4, 401)
    told = np.sin(5 * times) ** 3
    first = servos(problem, told, times, "servo_lag", lag=0.1)
    gaps = [
        np.abs(servos(problem, told, times, "servo_inertia", lag=0.1, damping=d) - first).max() for d in (4.0, 8.0, 1e6)
    ]
    assert gaps[0] / gaps[1] == pytest.approx(4, rel=0.1)
    assert gaps[2] < 1e-11
