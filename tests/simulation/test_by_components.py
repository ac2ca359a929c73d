"""Dry friction by components and by the plain slip: by hand, against plain minimisation, roots half a turn away."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest

from oracle import power_laws
from oracle.chain import place, vertex_tangents
from oracle.integrator import cross
from serpenoid.effects import find
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.element import Drag
from serpenoid.mechanics import functions
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.simulation import simulate_joint_angles
from serpenoid.simulation.balance import Placed, solve_balance, solve_near
from serpenoid.simulation.sensitivity import step_sensitivities
from serpenoid.simulation.steps import elements_of_vertices
from specimens import random_table, reference, serpenoid_table

EPS = 0.15
LAW = "coulomb_by_components"


def friction(softening: float = 0.01, **model: object) -> Model:
    medium = Medium(anisotropy_ratio=EPS, law=LAW, softening=softening)
    return Model(reference().body, medium, **model)  # type: ignore[arg-type]


def test_the_energy_and_its_gradient_are_those_written_by_hand() -> None:
    shapes = np.random.default_rng(5).normal(size=(2, 12, 2)) * 0.02 + np.linspace(-0.5, 0.5, 12)[:, None] * [1, 0]
    model, pose = friction(softening=1e-6), np.array([0.03, -0.05, 0.2])
    before, after = (elements_of_vertices(model, shape[None]) for shape in shapes)
    found = float(functions.step_energy(model.structure)(before, after, pose, model.parameters))
    w = model.body.vertex_weights
    energy, gradient = power_laws.energy_by_components(pose, shapes[0], shapes[1], w, EPS, degree=1)
    assert found == pytest.approx(energy, abs=1e-6)
    turn, *force = functions.step_momentum(model.structure)(before, after, pose, model.parameters).full()[:, 0]
    moment = gradient[2] + pose[0] * gradient[1] - pose[1] * gradient[0]
    np.testing.assert_allclose([*force, turn], [gradient[0], gradient[1], moment], atol=1e-6)
    h, slopes = 1e-7, []
    for step in np.eye(3) * h:  # the oracle's own gradient, by differences
        pair = [power_laws.energy_by_components(pose + s * step, *shapes, w, EPS, degree=1)[0] for s in (1, -1)]
        slopes.append((pair[0] - pair[1]) / (2 * h))
    np.testing.assert_allclose(gradient, slopes, atol=1e-6)
    assert np.ptp(place(pose, shapes[1])) > 0


def test_motion_is_that_of_plain_minimisation() -> None:
    table = serpenoid_table(reference(), 50)
    body = reference().body
    run = power_laws.simulate(table, body.edges, body.vertex_weights, EPS, degree=1, by_components=True)
    motions = [simulate_joint_angles(friction(softening=s), table) for s in (0.1, 0.01, 0.001)]
    errors = [np.abs(m.poses - run.poses).max() for m in motions]
    assert all(m.status.ok for m in motions)
    assert errors[2] < errors[1] < errors[0]
    assert errors[2] < 1e-3
    assert motions[2].dissipation == pytest.approx(run.energies.sum(), rel=1e-3)


def test_a_wheel_that_slides_sideways_resists_rolling_as_much_as_ever() -> None:
    """A straight body that moves askew: a box of forces, where the ellipse lets the lengthwise part vanish."""
    line = np.stack([np.linspace(-0.5, 0.5, 12), np.zeros(12)], axis=1)[None].repeat(2, axis=0)
    model = friction(softening=1e-6)
    before, after = (elements_of_vertices(model, shape[None]) for shape in line)
    for askew in (0.0, 0.05, 0.3):
        pose = np.array([0.1, askew, 0.0])
        force = functions.step_momentum(model.structure)(before, after, pose, model.parameters).full()[1:, 0]
        np.testing.assert_allclose(force, [EPS, float(askew > 0)], atol=1e-5)


@pytest.mark.parametrize("sharpness", [1.5, 2.0, 2.7, 8.0])
@pytest.mark.parametrize("law", ["coulomb", LAW])
def test_creep_is_drag_far_below_its_speed_and_nothing_far_above(law: str, sharpness: float) -> None:
    table = serpenoid_table(reference(), 20)
    medium = Medium(anisotropy_ratio=EPS, law=law)

    def played(speed: float) -> np.ndarray:
        creep = ActiveEffect.of("creep", creep_speed=speed, sharpness=sharpness)
        return simulate_joint_angles(Model(reference().body, medium, (creep,), cycle_duration_s=2000.0), table).poses

    hard = simulate_joint_angles(Model(reference().body, medium, cycle_duration_s=2000.0), table).poses
    drag = Medium(anisotropy_ratio=EPS**2 if law == "coulomb" else EPS)
    soft = simulate_joint_angles(Model(reference().body, drag), table).poses
    np.testing.assert_allclose(played(1e-9), hard, atol=1e-3)
    np.testing.assert_allclose(played(1.0), soft, atol=1e-3)
    assert np.abs(hard - soft).max() > 0.02


def test_sharpness_of_two_is_a_softened_norm_and_two_point_seven_nearly_a_hyperbolic_tangent() -> None:
    x, zero = np.geomspace(0.01, 100, 400), ca.SX(0)
    slip, sharpness = ca.SX.sym("slip"), ca.SX.sym("sharpness")
    dry = Drag(zero, zero, zero, zero, slip, 1 / slip, 1 / slip, zero, *[ca.SX(1)] * 3)
    symbols = SimpleNamespace(creep_speed=1.0, sharpness=sharpness)
    force = ca.Function("force", [slip, sharpness], [slip * find("creep").on_drag(dry, symbols).along])  # type: ignore[attr-defined]
    soft, sharp = (force(x[None], p).full()[0] for p in (2.0, 2.7))
    np.testing.assert_allclose(soft, x / np.sqrt(1 + x**2), rtol=1e-12)
    assert np.abs(sharp - np.tanh(x)).max() < 0.02


def test_derivatives_by_the_numbers_of_the_law_agree_with_differences() -> None:
    model = friction(effects=(creep(0.01, 2.5),), cycle_duration_s=2.0)
    motion = simulate_joint_angles(model, random_table(reference(), np.random.default_rng(4), 12))
    times, h = np.linspace(0, 2.0, 13), np.array([1e-6, 1e-4])
    found = step_sensitivities(model, motion.vertices, times)
    for i, by in enumerate(np.diag(h)):
        pair = [
            step_sensitivities(
                friction(effects=(creep(0.01 + s * by[0], 2.5 + s * by[1]),), cycle_duration_s=2.0),
                motion.vertices, times,
            ).relative
            for s in (1, -1)
        ]  # fmt: skip
        np.testing.assert_allclose(found.jacobian[:, :, 1 + i], (pair[0] - pair[1]) / (2 * h[i]), rtol=1e-3, atol=1e-5)


def creep(speed: float, sharpness: float) -> ActiveEffect:
    return ActiveEffect.of("creep", creep_speed=speed, sharpness=sharpness)


def test_a_step_of_effects_on_dry_friction_turns_no_half_circle() -> None:
    """A chain laid back on itself resists as little to first sight: such roots were taken for steps."""
    rng = np.random.default_rng(7)
    model = friction(effects=(creep(0.01, 2.7), ActiveEffect.typical("toe")), cycle_duration_s=3.0)
    motion = simulate_joint_angles(model, random_table(reference(), rng, 12))
    assert motion.status.ok
    times = np.linspace(0, 3.0, 13)
    m = model.structure.elements
    elements = elements_of_vertices(model, motion.vertices)
    spans, starts = np.column_stack([times[:-1], times[1:]]), np.zeros((12, 3))
    astray = np.tile([0.0, 0.0, 3.0], (12, 1))
    given = Placed(elements[:, :-m], elements[:, m:], spans, starts)
    plain = solve_balance(model, given, np.zeros((12, 3)))
    assert not solve_near(model, given, astray).sound.any()  # wherever they lead
    np.testing.assert_allclose(np.abs(plain.relative[:, 2]).max(), 0, atol=0.35)


def test_by_the_plain_slip_forces_and_moments_written_by_hand_are_balanced() -> None:
    """f = -w (v_n N + eps v_t T) / |v|, of the mean of both tangents' forces, each at the other end of its step."""
    medium = Medium(anisotropy_ratio=EPS, law="coulomb_plain", softening=1e-4)
    model = Model(reference().body, medium)
    motion = simulate_joint_angles(model, random_table(reference(), np.random.default_rng(4), 12))
    assert motion.status.ok
    weights = model.body.vertex_weights
    for first, second in pairwise(motion.vertices):
        dp = second - first
        ways = [vertex_tangents(p) for p in (first, second)]
        speed = np.linalg.norm(dp, axis=1)
        forces = [
            weights[:, None] * (dp + (EPS - 1) * np.sum(dp * t, axis=1)[:, None] * t) / speed[:, None] for t in ways
        ]
        np.testing.assert_allclose(sum(f.sum(axis=0) for f in forces), 0, atol=2e-3)
        moment = sum(cross(p, f).sum() for p, f in zip((second, first), forces, strict=True))
        np.testing.assert_allclose(moment, 0, atol=2e-3)
    table = serpenoid_table(reference(), 20)
    isotropic = [Model(reference().body, Medium(anisotropy_ratio=1.0, law=law)) for law in ("coulomb", "coulomb_plain")]
    same, other = (simulate_joint_angles(m, table) for m in isotropic)
    np.testing.assert_allclose(other.poses, same.poses, atol=1e-9)
    assert other.dissipation == pytest.approx(same.dissipation, rel=1e-9)


def test_the_momentum_of_the_plain_slip_vanishes_where_its_steps_are() -> None:
    model = Model(reference().body, Medium(anisotropy_ratio=EPS, law="coulomb_plain", softening=1e-4))
    motion = simulate_joint_angles(model, serpenoid_table(reference(), 20))
    m = model.structure.elements
    elements = elements_of_vertices(model, motion.vertices)
    momentum = functions.step_momentum(model.structure)
    for s in (0, 7, 15):
        pair = elements[:, m * s : m * (s + 1)], elements[:, m * (s + 1) : m * (s + 2)]  # where they are
        np.testing.assert_allclose(momentum(*pair, np.zeros(3), model.parameters).full(), 0, atol=1e-5)  # softened
        assert np.abs(momentum(*pair, np.array([0.01, 0.01, 0.0]), model.parameters).full()).max() > 1e-2
