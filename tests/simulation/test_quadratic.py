"""Motion with quadratic drag: against plain minimisation, its invariants, its softening, a speed by hand."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from oracle import power_laws
from serpenoid.body import Floats
from serpenoid.effects.active import ActiveEffect
from serpenoid.mechanics.tables import joint_table
from serpenoid.media import LAWS
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.simulation import simulate_joint_angles
from serpenoid.simulation.sensitivity import step_sensitivities
from specimens import random_table, reference

EPS = 0.4
EXACT = 1e-9  # residual 1e-12 over a stiffness in proportion to the slip


def swimmer(eps: float = EPS, softening: float = 0.01, **model: object) -> Model:
    medium = Medium(anisotropy_ratio=eps, law="quadratic", softening=softening)
    return Model(reference().body, medium, **model)  # type: ignore[arg-type]


def test_motion_is_that_of_plain_minimisation_and_softening_errs_by_its_square() -> None:
    table = random_table(reference(), np.random.default_rng(1), 12)
    run = power_laws.simulate(table, reference().body.edges, reference().body.vertex_weights, EPS, degree=3)
    motions = [simulate_joint_angles(swimmer(softening=s), table) for s in (0.3, 0.1, 0.01, 0.001)]
    errors = [np.abs(m.poses - run.poses).max() for m in motions]
    assert all(m.status.ok for m in motions)
    assert errors[1] < errors[0] / 6  # (1/3)^2
    assert errors[2] < errors[1] / 50  # (1/10)^2
    assert errors[3] < 1e-5  # what the plain search leaves
    assert motions[3].energy_raw == pytest.approx(run.energies.sum(), rel=1e-5)


def test_order_two_in_time_and_work_that_converges_with_the_square_of_the_number_of_steps() -> None:
    gait = np.array([1.0, 0.0, 0.0, 0.0, 6.0, 1.0])
    found = [simulate_joint_angles(swimmer(), joint_table(swimmer(), gait, n)) for n in (40, 80, 160)]
    steps = [fine.displacement - coarse.displacement for coarse, fine in pairwise(found)]
    assert steps[0] / steps[1] == pytest.approx(4, rel=0.1)
    work = [motion.steps_per_cycle**2 * motion.energy_raw for motion in found]
    assert abs(work[2] - work[1]) < abs(work[1] - work[0]) / 3 < 5e-3 * work[2]
    assert found[2].dissipation == pytest.approx(work[2], rel=1e-12)


def test_a_straight_body_that_is_pulled_reaches_its_speed_as_the_hyperbolic_tangent_says() -> None:
    """m dv/dt = p - v^2 from rest: x = m ln cosh(sqrt(p) t / m), with p in m2/s2 and m in metres; order two."""
    pull, mass, duration = 0.04, 0.3, 3.0
    effects = (ActiveEffect.of("slope", pull_x=pull, pull_y=0.0), ActiveEffect.of("inertia", relaxation_time=mass))
    units = [p.unit_in(LAWS["quadratic"]) for e in effects for p in e.effect.parameters]
    assert units == ["m2/s2", "m2/s2", "m"]
    model = swimmer(eps=1.0, effects=effects, cycle_duration_s=duration)
    far = mass * np.log(np.cosh(np.sqrt(pull) * duration / mass)) / model.body.total_length_m
    tables = [np.zeros((steps + 1, model.body.joint_count)) for steps in (30, 60, 120)]
    gone = [simulate_joint_angles(model, table, closed=False).poses[-1, 0] for table in tables]
    errors = [abs(x - far) for x in gone]
    assert errors[2] < errors[1] / 3 < errors[0] / 9
    assert errors[2] < 1e-3 * far


def test_derivatives_for_fits_agree_with_differences_for_eps_and_an_effect() -> None:
    effect = ActiveEffect.of("worn_wheel", 3, seizure=0.2)
    model = swimmer(effects=(effect,), cycle_duration_s=2.0)
    motion = simulate_joint_angles(model, random_table(reference(), np.random.default_rng(4), 12))
    times, h = np.linspace(0, 2.0, 13), 1e-5
    found = step_sensitivities(model, motion.vertices, times)
    assert found.sound.all()

    def predicted(eps: float, seizure: float) -> Floats:
        effects = (ActiveEffect.of("worn_wheel", 3, seizure=seizure),)
        changed = replace(model, medium=model.medium.with_ratio(eps), effects=effects)
        return step_sensitivities(changed, motion.vertices, times).relative

    by_eps = (predicted(EPS + h, 0.2) - predicted(EPS - h, 0.2)) / (2 * h)
    by_effect = (predicted(EPS, 0.2 + h) - predicted(EPS, 0.2 - h)) / (2 * h)
    np.testing.assert_allclose(found.jacobian[:, :, 0], by_eps, atol=1e-6)
    np.testing.assert_allclose(found.jacobian[:, :, 1], by_effect, atol=1e-6)
