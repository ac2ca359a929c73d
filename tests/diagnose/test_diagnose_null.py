"""What a search finds on nothing is no more than its null says, with chance alone and with errors that gaits repeat."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.diagnose.inference.fits.evidence import Evidence
from serpenoid.diagnose.inference.fits.prices import gained_by_chance, most_gained
from serpenoid.diagnose.inference.search.null import Scored, largest_by_chance

GAITS, EACH, CANDIDATES, CAMPAIGNS = 6, 40, 30, 60
LABELS = np.repeat(np.arange(GAITS), EACH)


def campaign(seed: int, discrepancy: float, cause: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Residuals (R,) and columns (R, 1 + CANDIDATES).

    discrepancy: of each gait, along columns 1 to 3, in a measure of its own; cause: along the last, alike in all.
    """
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(len(LABELS), 1 + CANDIDATES))
    wrong = rng.normal(size=(GAITS, 3))[LABELS] * x[:, 1:4]
    return rng.normal(size=len(x)) + discrepancy * wrong.sum(axis=1) + cause * x[:, -1], x


def about(residuals: np.ndarray, x: np.ndarray, own: list[int]) -> tuple[Scored, np.ndarray]:
    """Evidence about a fit of the columns `own`, and what each other column would gain."""
    x = x[:, [*own, *(i for i in range(x.shape[1]) if i not in own)]]
    fitted = x[:, : len(own)]
    left = residuals - fitted @ np.linalg.lstsq(fitted, residuals, rcond=None)[0]
    evidence = Evidence.of(left, x, LABELS)
    mine, groups = list(range(len(own))), tuple((i,) for i in range(len(own), x.shape[1]))
    gains = np.array([evidence.chi2(mine) - evidence.chi2([*mine, *g]) for g in groups])
    return Scored(evidence, len(own), groups), gains


@pytest.mark.parametrize(("discrepancy", "alarms"), [(0.0, 3), (0.7, 6)])
def test_the_best_candidate_rarely_gains_more_than_the_null(discrepancy: float, alarms: int) -> None:
    found = [about(*campaign(seed, discrepancy), [0]) for seed in range(CAMPAIGNS)]
    # one in a hundred, and three binomial standard deviations; six gaits tell a discrepancy's size to a third only
    assert sum(gains.max() > largest_by_chance([s]) for s, gains in found) <= alarms
    if discrepancy:  # taken for chance, most of these would get a name
        as_chance = gained_by_chance(CANDIDATES) + np.log(len(LABELS))
        assert sum(gains.max() > as_chance for _, gains in found) > CAMPAIGNS / 2


def test_a_cause_that_all_gaits_show_alike_gains_more_than_the_null_of_what_it_leaves() -> None:
    residuals, x = campaign(1, 0.3, cause=1.5)
    _, gains = about(residuals, x, [0])
    left, _ = about(residuals, x, [0, CANDIDATES])
    assert gains[-1] > largest_by_chance([left])
    assert gains.argmax() == CANDIDATES - 1


def test_a_candidate_within_the_fits_own_columns_says_nothing() -> None:
    rng = np.random.default_rng(2)
    x = rng.normal(size=(len(LABELS), 2))
    x = np.column_stack([x, x[:, 0] + 1e-9 * x[:, 1]])
    assert largest_by_chance([about(rng.normal(size=len(x)), x, [0, 1])[0]]) == 0.0


@pytest.mark.parametrize(("parameters", "tries"), [(1, 20), (3, 200)])
def test_the_truth_is_excluded_by_the_best_of_its_rivals_no_more_often_than_stated(parameters: int, tries: int) -> None:
    best = np.random.default_rng(3).chisquare(parameters, (2000, tries)).max(axis=1)
    assert (best > most_gained(parameters, tries)).mean() == pytest.approx(0.01, abs=0.007)  # three binomial deviations
