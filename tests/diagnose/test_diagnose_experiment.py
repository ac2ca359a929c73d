"""The next experiment: within the robot's limits, worth more than random trials, and no difference counted that a refit
of eps or of the rivals' own parameters would take up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rehearsal import serpenoid_table, snake
from serpenoid.diagnose.data.noise.motion import Noise
from serpenoid.diagnose.design.contest import Explanation, Plan, expected_chi2
from serpenoid.diagnose.design.experiment import Laboratory, next_experiment, planned, playable, table_of
from serpenoid.diagnose.inference.fits.evidence import Evidence
from serpenoid.diagnose.inference.fits.medium import Fit
from serpenoid.effects.active import ActiveEffect
from serpenoid.measure.schedule import Schedule
from serpenoid.medium import Medium
from serpenoid.model import Model

NOISE = Noise(np.array([1e-4, 1e-4, 5e-4]), np.array([1e-4, 1e-4, 5e-4]))
BODY = snake().body
PLAN = Plan(Schedule(serpenoid_table(50), 2.5, 2, 1.0), np.array([0.1, -0.2, 0.4]))
DRY = ActiveEffect.of("dry_friction", crossover_speed=0.05)
POWER = ActiveEffect.of("power_law_drag", exponent=0.8)


def explained(eps: float, spread: tuple[float, ...], *effects: ActiveEffect) -> Fit:
    """A fit with independent parameters of the given standard deviations, eps first."""
    matrix = np.diag(1 / np.square(spread))[None]
    evidence = Evidence(matrix, np.zeros((1, len(spread))), np.zeros(1), np.ones(1))
    model = Model(BODY, Medium(anisotropy_ratio=eps), effects)
    return Fit(model, evidence, (), 0.0)


def apart(one: Fit, other: Fit, plan: Plan = PLAN) -> float:
    return float(expected_chi2(Explanation.of(one), [Explanation.of(other)], NOISE, plan)[0])


def test_axes_make_up_the_covariance() -> None:
    x = np.random.default_rng(0).normal(size=(9, 3))
    evidence = Evidence.of(np.ones(9), x, np.zeros(9))
    axes = Explanation.of(replace(explained(0.2, (0.01,)), evidence=evidence, model=slanted())).axes
    np.testing.assert_allclose(axes.T @ axes, np.linalg.inv(x.T @ x), rtol=1e-6)  # the ridge is 1e-9


def slanted() -> Model:
    return Model(BODY, Medium(anisotropy_ratio=0.2), (ActiveEffect.of("slope", pull_x=1e-3, pull_y=0.0),))


def test_a_difference_of_eps_counts_only_where_eps_is_known() -> None:
    known, unknown = (
        apart(explained(0.20, (1e-6,)), explained(0.21, (1e-6,))),
        apart(explained(0.20, (1e-6,)), explained(0.21, (0.1,))),
    )
    assert known > 100
    assert unknown < 0.02 * known  # 0.01 is a tenth of a standard deviation: 0.01, and what is not linear


def test_the_same_explanation_is_never_told_from_itself() -> None:
    assert apart(explained(0.2, (0.01, 0.01), DRY), explained(0.2, (0.01, 0.01), DRY)) == 0


def test_expected_chi2_is_that_of_the_best_refit_of_both() -> None:
    one, other = (Explanation.of(explained(0.2, (0.01, 0.02), e)) for e in (DRY, POWER))
    repeats = PLAN.repeats * PLAN.schedule.cycles
    a, b = one.predicted(PLAN), other.predicted(PLAN)
    d = ((a - b) / NOISE.playing).ravel() * np.sqrt(repeats)
    columns = np.concatenate([one.spread(PLAN, a), other.spread(PLAN, b)]) / NOISE.playing
    design = np.vstack([columns.reshape(4, -1).T * np.sqrt(repeats), np.eye(4)])
    left = np.linalg.lstsq(design, np.concatenate([d, np.zeros(4)]), rcond=None)[1]
    assert expected_chi2(one, [other], NOISE, PLAN) == pytest.approx(left, rel=1e-9)


def test_laws_without_a_speed_are_told_apart_no_better_by_another_duration() -> None:
    one, other = explained(0.2, (0.01,)), explained(0.2, (0.01, 0.05), ActiveEffect.of("toe", angle=0.03))
    slow = replace(PLAN, schedule=replace(PLAN.schedule, cycle_duration_s=7.0))
    assert apart(one, other, slow) == pytest.approx(apart(one, other), rel=1e-6)  # roots are solved to 1e-12
    assert apart(one, explained(0.2, (0.01, 0.01), DRY), slow) > 1.5 * apart(one, explained(0.2, (0.01, 0.01), DRY))


def test_what_the_robot_cannot_do_is_not_proposed() -> None:
    table = serpenoid_table(50)
    assert playable(BODY, table, 3.0)
    assert not playable(BODY, table, 0.3)  # too fast
    assert not playable(BODY, 3 * table, 30.0)  # beyond the joints' limits
    assert not playable(BODY.model_copy(update={"joint_limit_deg": 180.0}), np.full((50, 10), 1.2), 30.0)  # a knot


def test_joints_to_one_side_play_about_the_middle_of_their_range() -> None:
    one_sided = BODY.model_copy(update={"joint_limit_deg": (-10.0, 60.0)})
    low, high = np.deg2rad([-10, 60])
    table = table_of(Model(one_sided, Medium(anisotropy_ratio=0.2)), np.array([1.0, 0.0, 0.0, 0.0, 4.0, 1.0]))
    np.testing.assert_allclose(table.mean(axis=0), (low + high) / 2, atol=1e-6)  # written with six decimals
    assert low < table.min()
    assert table.max() < high
    assert not playable(one_sided, table - np.deg2rad(25), 30.0)


def test_the_proposed_trial_is_playable_and_better_than_random_ones() -> None:
    corners = np.array([-0.3, -0.3]), np.array([0.3, 0.3])
    rivals = (explained(0.2, (0.01, 0.02), POWER),)
    laboratory = Laboratory(explained(0.2, (0.01, 0.02), DRY), rivals, NOISE, PLAN.schedule, (2.0, 6.0), corners)
    found = next_experiment(laboratory)
    assert found is not None
    schedule = found.plan.schedule
    assert playable(BODY, schedule.table, schedule.cycle_duration_s)
    assert 2.0 <= schedule.cycle_duration_s <= 6.0
    assert (np.abs(found.plan.start[:2]) <= 0.3).all()
    assert found.chi2[0] > apart(laboratory.choice, rivals[0])
    assert found.chi2[0] == pytest.approx(apart(laboratory.choice, rivals[0], found.plan))


def test_a_start_off_the_floor_is_refused() -> None:
    corners = np.array([-0.3, -0.3]), np.array([0.3, 0.3])
    laboratory = Laboratory(explained(0.2, (0.01,)), (), NOISE, PLAN.schedule, (2.0, 6.0), corners)
    x = np.array([0.8, 0, 0, 0, 5.0, 1.0, np.log(4.0), 0.0, 0.1, 0.1])
    assert planned(laboratory, x) is not None
    x[8] = 0.4
    assert planned(laboratory, x) is None
