"""Performance ratios: published identities, and what mean and SD of Xi cannot see."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from serpenoid.compare.ratios import performance_ratios, ratio_statistics, wrong_pairs
from serpenoid.errors import InputError


def _log_normal(s: float, gaits: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    y = rng.uniform(0.1, 0.6, gaits)
    return y * np.exp(s * rng.normal(size=gaits)), y


@pytest.mark.parametrize("s", [0.2005, *(pytest.param(s, marks=pytest.mark.slow) for s in (0.243, 0.299))])
def test_mean_of_xi_is_exp_s_squared_for_log_normal_quotients(s):
    found = ratio_statistics("X/Y", *_log_normal(s, 3000))
    assert found.mean == pytest.approx(np.exp(found.s**2), abs=0.004)  # 3000 gaits: fourth moments scatter by this much
    assert found.std == pytest.approx(np.sqrt(np.exp(4 * s**2) - np.exp(2 * s**2)), rel=0.06)


def test_published_means_are_those_of_the_published_s():
    # Even et al. 2024, Sec. V: mean 1.0410, 1.0609, 1.0932; s as in the design notes
    for s, mean in ((0.2005, 1.0410), (0.243, 1.0609), (0.299, 1.0932)):
        assert np.exp(s**2) == pytest.approx(mean, abs=5e-4)  # s is quoted to three or four digits


def test_a_hidden_factor_three_leaves_mean_and_std_alone_and_is_caught_by_the_bias():
    x, y = _log_normal(0.2, 24)
    plain, scaled = ratio_statistics("X/Y", x, y), ratio_statistics("X/Y", 3 * x, y)
    assert scaled.mean == pytest.approx(plain.mean, rel=1e-12)
    assert scaled.std == pytest.approx(plain.std, rel=1e-12)
    assert scaled.bias == pytest.approx(3 * plain.bias, rel=1e-12)
    assert scaled.bias_interval[0] > 1.5
    assert plain.bias_interval[0] < 1 < plain.bias_interval[1]


@given(st.lists(st.floats(0.05, 5.0), min_size=3, max_size=8), st.integers(0, 99))
def test_mean_of_xi_is_never_below_one(values, seed):
    y = np.random.default_rng(seed).uniform(0.1, 1, len(values))
    assert ratio_statistics("X/Y", np.array(values), y).mean >= 1 - 1e-12


def test_ratios_multiply_to_one_across_the_diagonal():
    delta = performance_ratios(np.array([0.1, 0.4, 0.7]))
    np.testing.assert_allclose(delta * delta.T, 1.0)


def test_interval_of_s_covers_the_truth():
    hits = 0
    for seed in range(200):
        low, high = ratio_statistics("X/Y", *_log_normal(0.2, 24, seed)).s_interval
        hits += low <= 0.2 <= high
    # a percentile bootstrap of a spread from 24 values is known to cover less than its 95 %
    assert 0.84 <= hits / 200 <= 0.98


def test_wrongly_ordered_pairs_are_named():
    assert wrong_pairs(np.array([3.0, 2.0, 1.0]), np.array([2.0, 3.0, 1.0])) == ((0, 1),)


def test_two_gaits_have_no_rank_correlation_and_it_is_shown_as_a_dash():
    assert ratio_statistics("X/Y", np.array([1.0, 2.0]), np.array([1.0, 1.5])).rank_text == "-"
    assert ratio_statistics("X/Y", np.array([1.0, 2.0, 3.0]), np.array([1.0, 1.5, 2.0])).rank_text == "1.000"


def test_a_gait_that_does_not_move_is_refused():
    with pytest.raises(InputError, match="must be positive.*leave it out"):
        ratio_statistics("X/Y", np.array([1.0, 0.0]), np.array([1.0, 1.0]))
