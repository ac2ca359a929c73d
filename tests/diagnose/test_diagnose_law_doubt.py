"""Values about a law that is wrong: how often their intervals hold the truth, and what they cost where it is right."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from serpenoid.diagnose.inference.doubt import law_doubt
from serpenoid.diagnose.inference.doubt.law_doubt import Doubted, with_errors_of_gaits, yielding
from serpenoid.diagnose.inference.fits.finding import Named
from serpenoid.effects.active import ActiveEffect

GAITS, WINDOWS, NORMAL = 6, 60, 1.96
TRUTH = np.array([0.2, 0.1])  # eps, an effect


def fitted(rng: np.random.Generator, share: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Errors and deviations of (eps, effect), and deviations by curvature, on a law that is off by a share of itself:
    by so much in all gaits, and by as much again from gait to gait."""
    common, blocks = rng.normal(size=2), []
    for _ in range(GAITS):
        columns = rng.normal(size=(WINDOWS, 2)) * rng.uniform(0.3, 3.0) / TRUTH
        off = share * TRUTH * (common + rng.normal(size=2))
        blocks.append((columns, columns @ off + rng.normal(size=WINDOWS)))
    matrix = np.stack([x.T @ x for x, _ in blocks])
    vector = np.stack([x.T @ r for x, r in blocks])
    moved, deviations = with_errors_of_gaits(matrix, vector, TRUTH**2 * np.diagonal(matrix, axis1=1, axis2=2))
    return moved, deviations, np.sqrt(np.diag(np.linalg.inv(matrix.sum(axis=0))))


def test_intervals_about_a_law_that_is_wrong_hold_the_truth_as_often_as_they_say() -> None:
    rng = np.random.default_rng(1)
    held = np.array([np.abs(moved) <= NORMAL * sd for moved, sd, _ in (fitted(rng, 0.2) for _ in range(60))])
    # 95 % stated; six gaits tell their own scatter to a third, which costs a few per cent; 120 draws: SD 2 to 3 %
    assert 0.85 < held.mean() <= 1.0


def test_where_the_law_is_right_intervals_are_those_of_chance() -> None:
    rng = np.random.default_rng(2)
    wider = np.array([sd / chance for _, sd, chance in (fitted(rng, 0.0) for _ in range(40))])
    assert wider.min() > 0.99  # no narrower than curvature
    assert np.median(wider) < 1.5  # six gaits scatter by chance, too


def told_by_one_gait(rng: np.random.Generator, share: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A (G, P, P), b (G, P) and what drag and the effect do (G, 2): gaits but the first show effect and eps alike but
    for a fiftieth, on a law that is off, as a motion, by a share of what the effect does."""
    matrix, vector, done = [], [], []
    for g in range(GAITS):
        eps, apart = rng.normal(size=(2, WINDOWS)) * rng.uniform(5.0, 20.0) / TRUTH[0]
        columns = np.stack([eps, (1.0 if g else -1.0) * 0.5 * eps + 0.01 * apart], axis=1)
        effect = columns[:, 1] * TRUTH[1]
        span = np.linalg.qr(columns)[0]
        off = span @ rng.normal(size=2) * share * np.linalg.norm(effect)
        matrix.append(columns.T @ columns)
        vector.append(columns.T @ (columns @ TRUTH + off + rng.normal(size=WINDOWS)))
        done.append((TRUTH[0] ** 2 * eps @ eps, effect @ effect))
    return np.stack(matrix), np.stack(vector), np.array(done)


def test_what_gaits_hardly_tell_puts_what_another_one_tells_in_no_doubt() -> None:
    """Where five gaits confuse the effect with eps, a motion that is off by little moves their values of it by many
    times itself; the sixth one, tail first, knows it to the law's error."""
    rng = np.random.default_rng(3)
    found = np.array([with_errors_of_gaits(*told_by_one_gait(rng, 0.3)) for _ in range(30)])  # (draws, 2, P)
    missed, deviations = np.abs(found[:, 0] - TRUTH), found[:, 1]
    assert np.median(deviations[:, 1]) < 0.45 * TRUTH[1]  # an error of 0.3 of one gait, and one in common
    assert np.sqrt((missed[:, 1] ** 2).mean()) < 0.45 * TRUTH[1]
    assert (missed < NORMAL * deviations).mean() > 0.85  # 60 draws, as above


def test_what_the_data_do_not_tell_stays_where_it_is() -> None:
    matrix = np.zeros((3, 2, 2))
    matrix[:, 0, 0] = 100.0
    moved, deviations = with_errors_of_gaits(matrix, np.zeros((3, 2)), np.ones((3, 2)))
    np.testing.assert_array_equal(moved, 0.0)
    assert deviations[0] > 0 == deviations[1]


def explanation(chi2: float, does: float = 1.0) -> Any:
    """With one coordinate; does: what a unit of it does."""
    evidence = SimpleNamespace(count=np.ones(1), matrix=np.full((1, 2, 2), does**2))
    fit = SimpleNamespace(chi2=chi2, evidence=evidence, effects=[SimpleNamespace(name="a", place=None)])
    return SimpleNamespace(labels=(1, 2, 3, 4, 5, 6, 6), unchanged=lambda _: [0.0]), fit, 1.0


def test_a_value_counts_by_what_it_does(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside a floor that resists a hundredth as much, a hundredth of a pull says as surely that there is one."""
    said = {100.0: 0.02, 1.0: 2.0, 10.0: -0.2}

    def of_gaits(_: object, fit: Any, __: object) -> tuple[np.ndarray, np.ndarray]:
        does = float(np.sqrt(fit.evidence.matrix[0, 1, 1]))
        return np.array([0.2, said[does]]), np.array([0.1, 0.3 / does])

    monkeypatch.setattr(law_doubt, "of_gaits", of_gaits)
    pull = law_doubt.doubted([explanation(1.0, 100.0), explanation(1.0, 1.0)])["a", None, 0]
    assert (pull.value, pull.deviation) == (pytest.approx(0.02), pytest.approx(0.003))
    low, high = pull.ends
    assert 0 < low < 0.02
    assert high > 2.0
    either = law_doubt.doubted([explanation(1.0, 1.0), explanation(1.0, 10.0)])["a", None, 0]
    assert either.ends[0] < 0 < either.ends[1]


def beside(several: list[tuple[float, float]], monkeypatch: pytest.MonkeyPatch) -> Doubted:
    """Of one coordinate, beside explanations that are as likely; several: its value and deviation beside each."""
    told = dict(enumerate(several))
    explanations = [explanation(1.0) for _ in several]
    for i, (_, fit, _) in enumerate(explanations):
        fit.number = i
    monkeypatch.setattr(
        law_doubt, "of_gaits", lambda _, f, __: (np.array([0.2, told[f.number][0]]), np.array([0.1, told[f.number][1]]))
    )
    return law_doubt.doubted(explanations)["a", None, 0]


def test_explanations_that_agree_that_there_is_a_change_do_not_leave_that_open(monkeypatch: pytest.MonkeyPatch) -> None:
    """They may differ in how large it is: one says 0.2, one 2; by their scatter it could be none."""
    apart = beside([(0.2, 0.05), (2.0, 0.5)], monkeypatch)
    assert abs(apart.value) < NORMAL * apart.deviation
    assert apart.away == pytest.approx(4.0)
    low, high = apart.ends
    assert 0 < low < 0.6
    assert high > 3.0
    below = beside([(-0.2, 0.05), (-2.0, 0.5)], monkeypatch)
    assert below.ends == pytest.approx((-high, -low))


def test_one_explanation_without_a_change_or_with_the_opposite_one_leaves_it_open(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of two that are as likely, one that tells nothing leaves a quarter of a normal distribution on either side."""
    for other in (0.0, -0.2):
        doubt = beside([(0.2, 0.01), (other, 0.01)], monkeypatch)
        assert doubt.away < 0.7
        assert doubt.ends[0] < 0 < doubt.ends[1]
    alone = beside([(0.2, 0.05)], monkeypatch)
    assert alone.away == pytest.approx(4.0)
    assert alone.ends == pytest.approx((0.2 - NORMAL * 0.05, 0.2 + NORMAL * 0.05), rel=1e-3)


def test_an_explanation_counts_by_how_likely_it_makes_what_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that leaves twice as much counts an eighth with six gaits; one that leaves nine times as much, 1 / 729, is
    none: a 95 % interval leaves out more."""
    said = {1.0: 2.0, 2.0: 5.0, 9.0: 50.0}
    monkeypatch.setattr(law_doubt, "of_gaits", lambda _, fit, __: (np.array([0.2, said[fit.chi2]]), np.full(2, 0.1)))
    alone = law_doubt.doubted([explanation(1.0)])["a", None, 0]
    both = law_doubt.doubted([explanation(1.0), explanation(2.0)])["a", None, 0]
    astray = law_doubt.doubted([explanation(1.0), explanation(9.0), explanation(9.0)])["a", None, 0]
    alike = law_doubt.doubted([explanation(1.0), explanation(1.0)])["a", None, 0]
    assert (alone.value, alone.deviation) == (2.0, pytest.approx(0.1))
    assert alike.deviation == pytest.approx(0.1)
    assert both.value == pytest.approx((2.0 + 5.0 / 8) / (1 + 1 / 8))
    assert both.deviation > alone.deviation
    assert astray == alone


def test_how_far_a_body_gives_way_on_the_floors_own_law_is_a_factor_of_a_change() -> None:
    """On drag that grows with the square of speed a body gives way half as far as on its secant."""
    load = Named(ActiveEffect.of("load", 6, share=0.09), {"share": (0.07, 0.13)}, 1.2)
    wide = yielding(load, 0.3, {("load", 6, 0): Doubted(0.1, 0.01)})
    assert wide.intervals["share"] == pytest.approx((0.1 * np.exp(-0.588), 0.1 * np.exp(0.588)))
    assert yielding(load, 0.0, {("load", 6, 0): Doubted(0.1, 0.01)}) == load
    assert yielding(load, 0.3, {}) == load  # where the law is not known to be wrong


def test_the_factor_is_of_what_is_away_from_the_value_that_changes_nothing() -> None:
    drag = Named(ActiveEffect.of("power_law_drag", exponent=1.2), {"exponent": (1.19, 1.21)}, 3.0)
    wide = yielding(drag, 0.5, {("power_law_drag", None, 0): Doubted(1.2, 0.005, resting=1.0)})
    assert wide.intervals["exponent"] == pytest.approx((1 + 0.2 * np.exp(-0.98), 1 + 0.2 * np.exp(0.98)))


def test_a_factor_keeps_to_bounds() -> None:
    worn = Named(ActiveEffect.of("worn_wheel", 2, seizure=0.8), {"seizure": (0.7, 0.9)}, 3.0)
    wide = yielding(worn, 0.5, {("worn_wheel", 2, 0): Doubted(0.8, 0.05)})
    assert wide.intervals["seizure"][1] == 1.0
