"""Motion with Coulomb friction: against plain minimisation, its invariants, its softening, published laws."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from oracle import power_laws
from serpenoid.body import Body
from serpenoid.effects.active import ActiveEffect
from serpenoid.mechanics.tables import joint_table
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.simulation import simulate_joint_angles
from serpenoid.simulation.sensitivity import step_sensitivities
from specimens import random_table, reference, serpenoid_table

EPS = 0.1865
EXACT = 1e-9  # residual 1e-12 over a stiffness that is small only along the body's easiest direction


def friction(eps: float = EPS, softening: float = 0.01, **model: object) -> Model:
    medium = Medium(anisotropy_ratio=eps, law="coulomb", softening=softening)
    return Model(reference().body, medium, **model)  # type: ignore[arg-type]


def test_motion_is_that_of_plain_minimisation_and_softening_errs_by_its_square() -> None:
    table = serpenoid_table(reference(), 50)
    run = power_laws.simulate(table, reference().body.edges, reference().body.vertex_weights, EPS, degree=1)
    motions = [simulate_joint_angles(friction(softening=s), table) for s in (0.1, 0.03, 0.01, 0.001)]
    errors = [np.abs(m.poses - run.poses).max() for m in motions]
    assert all(m.status.ok for m in motions)
    # between a factor of 0.3 and the next: (1/3)^2 and (1/10)^2
    assert errors[1] < errors[0] / 6
    assert errors[2] < errors[1] / 6
    assert errors[3] < 5e-6
    assert errors[2] < 2e-4  # the default: a fifth of a millimetre on a robot of one metre
    assert motions[3].dissipation == pytest.approx(run.energies.sum(), rel=1e-5)


def test_order_two_in_time_for_a_gait_that_slides_throughout() -> None:
    gait = np.array([1.0, 0.0, 0.0, 0.0, 6.0, 1.0])
    found = [simulate_joint_angles(friction(), joint_table(friction(), gait, n)) for n in (40, 80, 160, 320)]
    steps = [fine.displacement - coarse.displacement for coarse, fine in pairwise(found)]
    assert steps[0] / steps[1] == pytest.approx(4, rel=0.2)
    assert steps[1] / steps[2] == pytest.approx(4, rel=0.1)
    work = [motion.dissipation for motion in found]
    assert abs(work[3] - work[2]) < abs(work[2] - work[1]) / 2 < 5e-3 * work[3]  # it converges without a factor T


@pytest.mark.slow
def test_the_cheapest_slope_of_a_long_wave_falls_with_the_transverse_coefficient_to_the_minus_one_quarter() -> None:
    """Alben (2013): 1 / eps^2 is the side force over the tangential one per slip angle (serpenoid.media.coulomb)."""
    waves, steps, best = 4, 160, []
    for eps in (0.2, 0.1):
        medium = Medium(anisotropy_ratio=eps, law="coulomb", dissipation="edge")
        model = Model(Body(vertices=40 * waves + 1), medium)
        slopes, price = np.array([1.1, 1.4, 1.75]) * np.sqrt(eps), []
        for slope in slopes:
            gait = np.array([1, 0, 0, 0, slope * 2 * np.pi * waves, waves])
            table = joint_table(model, gait, steps)[: steps // 4 + 1]  # a quarter cycle is a quarter of the way
            motion = simulate_joint_angles(model, table, closed=False)
            price.append(motion.energy_raw / motion.displacement)
        a, b, _ = np.polyfit(np.log(slopes), price, 2)
        assert a > 0
        best.append(np.exp(-b / (2 * a)))
    exponent = np.log(best[1] / best[0]) / np.log((1 / 0.1**2) / (1 / 0.2**2))
    assert exponent == pytest.approx(-0.25, abs=0.01)


def test_derivatives_for_fits_agree_with_differences_for_eps_and_an_effect() -> None:
    load = ActiveEffect.of("load", 3, share=0.2)
    model = friction(effects=(load,), cycle_duration_s=2.0)
    motion = simulate_joint_angles(model, random_table(reference(), np.random.default_rng(4), 12))
    times = np.linspace(0, 2.0, 13)
    found = step_sensitivities(model, motion.vertices, times)
    assert found.sound.all()
    h = 1e-5

    def predicted(eps: float, share: float) -> np.ndarray:
        effects = (ActiveEffect.of("load", 3, share=share),)
        changed = replace(model, medium=model.medium.with_ratio(eps), effects=effects)
        return step_sensitivities(changed, motion.vertices, times).relative

    by_eps = (predicted(EPS + h, 0.2) - predicted(EPS - h, 0.2)) / (2 * h)
    by_load = (predicted(EPS, 0.2 + h) - predicted(EPS, 0.2 - h)) / (2 * h)
    np.testing.assert_allclose(found.jacobian[:, :, 0], by_eps, atol=1e-6)
    np.testing.assert_allclose(found.jacobian[:, :, 1], by_load, atol=1e-6)


@pytest.mark.parametrize(
    "name", ["worn_wheel", "rough_skin", "load", "toe", "slope", "inertia", "track_width", "contact_offset"]
)
def test_effects_act_on_friction_and_grow_from_nothing(name: str) -> None:
    table = serpenoid_table(reference(), 20)
    typical = ActiveEffect.typical(name, 4 if name in ("worn_wheel", "rough_skin", "load") else None)
    resting = [p.resting for p in typical.effect.parameters]
    plain = simulate_joint_angles(friction(cycle_duration_s=5.0), table)
    away = []
    for strength in (1e-3, 1.0):
        values = [r + strength * (c - r) for r, c in zip(resting, typical.coordinates, strict=False)]
        effect = typical.with_coordinates(values)
        motion = simulate_joint_angles(friction(effects=(effect,), cycle_duration_s=5.0), table)
        assert motion.status.ok
        away.append(np.abs(motion.poses - plain.poses).max())
    assert away[0] < 0.02 * away[1] + 1e-4
    assert away[1] > 1e-5
