"""Sums of squares gait by gait against ordinary least squares."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.diagnose.inference.fits.evidence import Evidence


@pytest.fixture
def problem() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    x = rng.normal(size=(60, 4))
    return x @ [1.0, 0.0, -2.0, 0.0] + 0.1 * rng.normal(size=60), x, np.repeat([0, 1, 2], 20)


def test_a_subset_of_columns_is_solved_as_least_squares_does(problem: tuple) -> None:
    r, x, labels = problem
    values, covariance = Evidence.of(r, x, labels).solve([0, 2])
    expected = np.linalg.lstsq(x[:, [0, 2]], r, rcond=None)[0]
    assert values == pytest.approx(expected, rel=1e-7)  # the ridge is 1e-9
    assert covariance == pytest.approx(np.linalg.inv(x[:, [0, 2]].T @ x[:, [0, 2]]), rel=1e-7)


def test_groups_of_columns_gain_side_by_side_what_each_gains_alone(problem: tuple) -> None:
    r, x, labels = problem
    x = np.column_stack([x, np.zeros(60), x[:, 1] + 1e-7 * x[:, 3]])  # one that is silent, two that are nearly one
    e, groups = Evidence.of(r, x, labels), [[2], [1, 3], [4], [1, 5], [3]]
    for group, (gained, values) in zip(groups, e.gains([0], groups), strict=True):
        alone, _ = e.solve([0, *group])
        assert gained == pytest.approx(e.chi2([0]) - e.chi2([0, *group]), rel=1e-9, abs=1e-9)
        assert values == pytest.approx(alone, rel=1e-6)
    assert e.gains([0], []) == []


def test_held_out_chi_squared_is_that_of_explicit_leave_one_gait_out(problem: tuple) -> None:
    r, x, labels = problem
    total = 0.0
    for gait in range(3):
        keep = labels != gait
        theta = np.linalg.lstsq(x[keep][:, [0, 1]], r[keep], rcond=None)[0]
        total += ((r[~keep] - x[~keep][:, [0, 1]] @ theta) ** 2).sum()
    assert Evidence.of(r, x, labels).held_out([0, 1]) == pytest.approx(total, rel=1e-6)


def test_a_useless_column_does_not_help_to_predict(problem: tuple) -> None:
    e = Evidence.of(*problem)
    assert e.held_out([0, 2]) < e.held_out([0])
    assert e.held_out([0, 2, 3]) > e.chi2([0, 2, 3])


def test_a_column_that_says_nothing_stays_at_zero() -> None:
    x = np.column_stack([np.ones(6), np.zeros(6)])
    values, _ = Evidence.of(np.ones(6), x, np.arange(6) // 3).solve([0, 1])
    assert values == pytest.approx([1.0, 0.0], abs=1e-8)


@pytest.mark.parametrize("seed", range(4))
def test_what_the_other_gaits_cannot_tell_stays_nearly_neutral_while_one_gait_is_held_out(
    problem: tuple, seed: int
) -> None:
    """A parameter that only gait 0 shows: gait 0 is predicted about as well as without it, not five times worse."""
    _, x, labels = problem
    x = np.where((labels == 0)[:, None] | (np.arange(4) != 2), x, 1e-3 * x)
    r = x @ [1.0, 0.0, -2.0, 0.0] + 0.1 * np.random.default_rng(seed).normal(size=60)
    e = Evidence.of(r / 0.1, x / 0.1, labels)
    values, _ = e.solve([0, 2])
    shrunk = e.shrinking([2], values[1:], np.zeros(1))
    assert e.held_out([0, 2]) > 5 * e.held_out([0])
    assert shrunk.held_out([0, 2]) < 1.3 * e.held_out([0])
    np.testing.assert_array_equal(shrunk.solve([0, 2])[0], values)


def test_what_the_other_gaits_do_tell_is_hardly_shrunk(problem: tuple) -> None:
    e = Evidence.of(*problem)
    values, _ = e.solve([0, 2])
    shrunk = e.shrinking([2], values[1:], np.zeros(1))
    assert shrunk.held_out([0, 2]) == pytest.approx(e.held_out([0, 2]), rel=0.01)


def test_a_column_held_at_its_bound_is_not_shrunk(problem: tuple) -> None:
    e = Evidence.of(*problem).without(2)
    shrunk = e.shrinking([2], np.zeros(1), np.array([-1.0]))
    assert shrunk.solve([0, 2], without=0)[0][1] == 0.0
    assert shrunk.held_out([0, 2]) == pytest.approx(e.held_out([0]))


def test_where_every_gait_pulls_its_own_way_the_covariance_is_their_scatter() -> None:
    rng, gaits, each = np.random.default_rng(5), 8, 200
    own = rng.normal(scale=0.5, size=(300, gaits))  # each gait's slope, far more unlike than its noise tells
    x, labels = rng.normal(size=(gaits * each, 1)), np.repeat(np.arange(gaits), each)
    missed, said = [], []
    for slopes in own:
        r = (1.0 + slopes[labels]) * x[:, 0] + rng.normal(size=len(x))
        value = Evidence.of(r, x, labels).solve([0])[0]
        found = Evidence.of(r - x @ value, x, labels)
        missed.append(value[0] - 1.0)
        said.append(found.covariance([0])[0, 0])
        assert said[-1] >= found.solve([0])[1][0, 0]
    # 300 tries tell a variance to 8 %: two and a half of these
    assert np.mean(said) == pytest.approx(np.var(missed), rel=0.2)
