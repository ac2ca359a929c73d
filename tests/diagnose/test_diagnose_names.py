"""A second effect is named where it is a cause, and not where it mends the law of the first."""

from __future__ import annotations

import numpy as np

from serpenoid.diagnose.inference.search.discrepancy import least_deviance

WINDOWS, WRONG = 300, 0.35  # WRONG: what the law gets wrong of what it does
PRICE = float(np.log(WINDOWS) + 2 * np.log(45))  # of one parameter and one of 45 candidates
DRAWS = 12


def gained(seed: int, second: float, wrong: float = WRONG) -> tuple[float, float]:
    """What a neighbour of the true effect gains beside it: in chi squared, and with the law's own error counted."""
    rng = np.random.default_rng(seed)
    first, other = rng.normal(size=(2, WINDOWS))
    neighbour = 0.8 * first + 0.6 * other
    done = 4.0 * first * (1 + wrong * rng.normal(size=WINDOWS))
    seen = done + second * neighbour + rng.normal(size=WINDOWS)

    def fitted(*columns: np.ndarray) -> tuple[float, float]:
        x = np.column_stack(columns)
        effect = x @ np.linalg.lstsq(x, seen, rcond=None)[0]
        left = seen - effect
        return float(left @ left), least_deviance(left, effect)

    return tuple(a - b for a, b in zip(fitted(first), fitted(first, neighbour), strict=True))  # type: ignore[return-value]


def test_a_neighbour_that_gains_by_the_laws_error_alone_is_no_cause() -> None:
    gains = np.array([gained(seed, second=0.0) for seed in range(DRAWS)])
    assert (gains[:, 1] < PRICE).all()


def test_a_second_cause_shows_beside_a_law_that_is_wrong_by_a_third() -> None:
    gains = np.array([gained(seed, second=1.5) for seed in range(DRAWS)])
    assert (gains[:, 1] > PRICE).all()


def test_where_the_law_is_exact_a_gain_is_that_of_chi_squared() -> None:
    for seed in range(DRAWS):
        squares, likelihood = gained(seed, second=0.5, wrong=0.0)
        # the worse of the two explanations leaves more than chance, and may call a part of that its law's error
        assert PRICE < likelihood < squares
        assert likelihood > squares / 2
