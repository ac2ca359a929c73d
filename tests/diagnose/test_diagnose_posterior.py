"""Noise, discrepancy, priors and odds against closed forms and draws of known truth."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import multivariate_normal

from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.inference.calibration import ERROR, Candidates, threshold
from serpenoid.diagnose.inference.discrepancy import PARTS, Blocks, Rows
from serpenoid.diagnose.inference.evidence import Evidence
from serpenoid.diagnose.inference.posterior import linear_gain, projected
from serpenoid.diagnose.inference.prior import WIDTHS, Prior
from serpenoid.effects.active import ActiveEffect

SETTINGS, REPEATS, CYCLES, PHASES = 8, 2, 2, 8
SCALE = 1e3  # a body length in noise levels


def rows(slid: float = 0.0) -> Rows:
    """A campaign's: every cycle with eight windows of play and two of rest."""
    setting, repeat, cycle, phase, direction = (
        x.ravel() for x in np.indices((SETTINGS, REPEATS, CYCLES, PHASES + 2, 3))
    )
    window = cycle * (PHASES + 2) + phase
    playing = phase < PHASES
    scale, moved = np.full(len(setting), SCALE), np.where(playing, 0.0, slid)
    return Rows(setting, direction, window, np.where(playing, phase, 99), playing, scale, moved)


def drawn(blocks: Blocks, sizes: np.ndarray, rng: np.random.Generator, count: int) -> np.ndarray:
    """Residuals (R,) of noise and discrepancy."""
    found = np.zeros(count)
    for index, covariance in zip(blocks.index, blocks.covariance(sizes), strict=True):
        found[index] = rng.multivariate_normal(np.zeros(len(index)), covariance)
    return found


def test_whitened_rows_have_the_quadratic_form_of_the_inverse_covariance() -> None:
    blocks, sizes = Blocks.of(rows(5.0)), np.array([1e-6, 4e-6, 2e-6, 0.3])
    x = np.random.default_rng(1).normal(size=(blocks.index.size, 2))
    white, dense = blocks.whitened(x, sizes), np.zeros((2, 2))
    for index, covariance in zip(blocks.index, blocks.covariance(sizes), strict=True):
        dense += x[index].T @ np.linalg.solve(covariance, x[index])
    np.testing.assert_allclose(white.T @ white, dense, rtol=1e-9)


def test_noise_alone_leaves_no_discrepancy_to_speak_of() -> None:
    blocks = Blocks.of(rows())
    for seed in range(5):
        sizes = blocks.likeliest(np.random.default_rng(seed).normal(size=blocks.index.size))
        # half of the noise level of one window: what 24 blocks of 32 windows can tell from none
        assert SCALE * np.sqrt(sizes.sum()) < 0.5


@pytest.mark.parametrize("part", range(3))
def test_the_part_of_the_discrepancy_that_is_there_is_found_in_its_size(part: int) -> None:
    blocks, true = Blocks.of(rows()), np.zeros(len(PARTS))
    true[part] = (5 / SCALE) ** 2
    found = np.array(
        [blocks.likeliest(drawn(blocks, true, np.random.default_rng(s), blocks.index.size)) for s in range(6)]
    )
    # 24 values tell a variance to 29 %, the mean of six draws to 12 %: two of these
    assert found[:, part].mean() == pytest.approx(true[part], rel=0.25)
    assert found[:, [i for i in range(3) if i != part]].mean() < 0.1 * true[part]


def test_a_body_that_sticks_in_pauses_makes_the_predicted_sliding_doubtful() -> None:
    r = rows(slid=10.0)
    blocks = Blocks.of(r)
    stuck = np.random.default_rng(2).normal(size=len(r.slid)) - r.slid  # predicted to slide, and does not
    found = blocks.likeliest(stuck)
    assert found[3] + found[2] * (SCALE / 10) ** 2 == pytest.approx(1.0, rel=0.5)
    misfit = (blocks.whitened(stuck[:, None], found) ** 2).sum()
    assert misfit < 1.3 * len(stuck)  # the pauses alone would be a hundred times chance


def test_an_effects_gain_is_the_ratio_of_marginal_likelihoods() -> None:
    rng = np.random.default_rng(4)
    x, r, width = rng.normal(size=(30, 2)), rng.normal(size=30), np.array([0.5, 2.0])
    gain = linear_gain(x.T @ x, x.T @ r, width)
    null = multivariate_normal.logpdf(r, np.zeros(30), np.eye(30))
    with_it = [multivariate_normal.logpdf(r, np.zeros(30), np.eye(30) + (x * (w * width) ** 2) @ x.T) for w in WIDTHS]
    assert gain == pytest.approx(np.log(np.mean(np.exp(np.array(with_it) - null))), rel=1e-9)


def on_floor(places: np.ndarray) -> Motion:
    """All that a prior asks of a campaign: where the bodies, a metre long, were."""
    track = SimpleNamespace(poses=places, recording=SimpleNamespace(body=SimpleNamespace(total_length_m=1.0)))
    return cast(Motion, SimpleNamespace(ratio=None, tracks=(track,)))


def test_priors_are_densities_and_their_pull_is_the_slope() -> None:
    motion = on_floor(np.array([[0.0, 0.0, 0.0], [2.0, 1.0, 0.0]]))
    prior = Prior.of(motion, [ActiveEffect.neutral("load", 3)])
    whole = quad(lambda v: np.exp(prior.log_density(np.array([0.2, v]))), -20, 20, points=[0.0], limit=400)[0]
    ratio = whole / np.exp(Prior.of(motion, []).log_density(np.array([0.2])))
    assert ratio == pytest.approx(1.0, abs=1e-6)
    patch = ActiveEffect.neutral("friction_patch", None, x=0.3, y=0.3, radius=0.2)
    for effect, values in ((ActiveEffect.neutral("load", 3), [-0.7]), (patch, [3.0, 0.4, -0.2, 0.3])):
        prior, x = Prior.of(motion, [effect]), np.array([0.3, *values])
        steps = 1e-6 * np.eye(len(x))
        slope = [(prior.log_density(x + d) - prior.log_density(x - d)) / 2e-6 for d in steps]
        np.testing.assert_allclose(-prior.pull(x)[0], slope, rtol=1e-6, atol=1e-6)


def test_a_patch_may_lie_anywhere_on_the_floor_that_was_visited_and_hardly_elsewhere() -> None:
    visited = np.array([[0.0, 0.0, 0.0], [4.0, 1.0, 0.0]])
    prior = Prior.of(on_floor(visited), [ActiveEffect.neutral("friction_patch", None, x=0.0, y=0.0, radius=0.2)])

    def at(x: float, y: float) -> float:
        return prior.log_density(np.array([0.2, 1.0, x, y, 0.25]))

    assert at(0.0, 0.5) == pytest.approx(at(4.0, 0.5))
    assert at(2.0, 0.5) - at(0.0, 0.5) < 1.5
    assert at(2.0, 0.5) - at(42.0, 0.5) > 3


def test_on_nothing_the_best_of_all_candidates_stays_below_the_threshold_at_the_stated_rate() -> None:
    rng = np.random.default_rng(5)
    x = rng.normal(size=(200, 40)) + rng.normal(size=(200, 1))
    columns = np.column_stack([np.ones(200), x])

    def said(residuals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return projected(Evidence.of(residuals, columns, np.zeros(200)), [0], range(1, 41), np.full(1, 10.0))

    matrix, _ = said(np.zeros(200))
    limit = threshold([Candidates(matrix, tuple((i,) for i in range(40)), (np.ones(1),) * 40, np.zeros(40))])
    vectors = np.stack([said(rng.normal(size=200))[1] for _ in range(1000)])
    gains = [linear_gain(matrix[i : i + 1, i : i + 1], vectors[:, i : i + 1], np.ones(1)) for i in range(40)]
    alarms = int((np.max(gains, axis=0) > limit).sum())
    # 400 draws know a 1 % quantile to within a factor of two, and a thousand tries count ten
    assert 0 < alarms < 1000 * 3 * ERROR
