"""A change and what explains its reference, together: which of several explanations a name is found beside."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from serpenoid.body import Body
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.windows.tracks import NoPath
from serpenoid.diagnose.inference.doubt import explanations
from serpenoid.diagnose.inference.doubt.explanations import Likely, acts, another
from serpenoid.diagnose.inference.search.discrepancy import least_deviance
from serpenoid.diagnose.inference.search.names import Try
from serpenoid.diagnose.reference import Explanation, Reference
from serpenoid.diagnose.stages.motion.choose_motion import with_a_path
from serpenoid.effects.active import ActiveEffect
from serpenoid.medium import Medium
from serpenoid.model import Model

DRIFT, SLOPE = ActiveEffect.typical("frame_drift"), ActiveEffect.typical("slope")


def test_what_a_frame_leaves_is_no_error_of_a_floors_law() -> None:
    """As much is left beside either, in proportion to what each does: of a push that a law may get wrong by so much, of
    a frame it is another cause."""
    rng = np.random.default_rng(5)
    done = 20.0 * rng.normal(size=500)
    left = 0.3 * done * rng.normal(size=500) + rng.normal(size=500)
    pushed, seen = least_deviance(left, done), least_deviance(left, np.zeros(500))
    assert seen - pushed > 100
    assert acts(SLOPE)
    assert not acts(DRIFT)


def test_as_likely_as_what_it_leaves_and_what_its_explanation_left() -> None:
    assert Likely(0.4, 2.0).over(Likely(1.0, 3.0)) == pytest.approx(0.4 * np.e)
    assert Likely(1.0, 3.0).over(Likely(0.4, 2.0)) == pytest.approx(2.5 / np.e)
    assert np.isfinite(Likely(1.0, 0.0).over(Likely(1.0, 1e6)))


@pytest.fixture
def beside(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Which explanation is taken, of how likely (effect, what it leaves) are beside each; the first is the baseline.
    found: what all names leave that were found beside it."""

    def taken(*several: tuple[float, list[tuple[ActiveEffect, float]]], found: float = 0.5) -> int | None:
        tries = [[Try(SimpleNamespace(left=left), e) for e, left in found] for _, found in several]  # type: ignore[arg-type]
        monkeypatch.setattr(explanations, "singles", lambda _, model: tries[model])
        monkeypatch.setattr(explanations, "likely", lambda _, fit, weight: Likely(weight, fit.left))
        selection: Any = SimpleNamespace(motion=None, best=SimpleNamespace(effects=(DRIFT,), left=found))
        return another(selection, [(None, i, weight) for i, (weight, _) in enumerate(several)])  # type: ignore[misc]

    return taken


def test_a_name_that_is_likelier_beside_another_explanation_takes_it(beside: Any) -> None:
    rolls, plain = [(DRIFT, 3.0), (SLOPE, 9.0)], [(DRIFT, 3.0), (SLOPE, 1.0)]
    assert beside((1.0, rolls), (0.4, plain)) == 1


def test_an_explanation_that_left_much_of_the_reference_counts_for_less(beside: Any) -> None:
    assert beside((1.0, [(DRIFT, 3.0)]), (0.1, [(SLOPE, 1.0)])) is None  # 0.1 e^2 < 1


def test_the_same_name_beside_another_explanation_changes_nothing(beside: Any) -> None:
    assert beside((1.0, [(DRIFT, 3.0)]), (0.9, [(DRIFT, 1.0)])) is None


def test_one_change_that_is_likelier_than_all_that_was_found_takes_its_explanation(beside: Any) -> None:
    assert beside((1.0, [(DRIFT, 3.0)]), (0.2, [(DRIFT, 1.0)]), found=2.5) is None  # 0.2 e^1.5 < 1
    assert beside((1.0, [(DRIFT, 3.0)]), (0.4, [(DRIFT, 1.0)]), found=2.5) == 1


def test_what_the_search_has_refused_beside_its_own_explanation_is_not_tried_again(beside: Any) -> None:
    assert beside((1.0, [(DRIFT, 3.0), (SLOPE, 2.0)]), (0.4, [(DRIFT, 3.0)])) is None


def test_a_reference_beside_another_explanation_has_it_first() -> None:
    body, unknown = Body(vertices=4), np.ones(3)
    models = [Model(body, Medium(anisotropy_ratio=eps)) for eps in (0.1, 0.2, 0.3)]
    explained = tuple(Explanation(m, chi2, {}) for m, chi2 in zip(models, (1.0, 2.0, 4.0), strict=True))
    plays: Any = None
    then = Reference(models[0], Observation.neutral(body), explained, unknown, unknown, plays, 0.003)
    other = then.beside(models[2])
    assert other.ratio == 0.3
    assert [e.model for e in other.explained] == [models[2], models[0], models[1]]
    assert other.inadequate


def test_where_an_explanation_has_no_path_the_next_one_is_the_baseline_and_eps_alone_the_last() -> None:
    body, unknown = Body(vertices=4), np.ones(3)
    models = [
        Model(body, Medium(anisotropy_ratio=0.1), effects) for effects in ((DRIFT,), (), (SLOPE,), (DRIFT, SLOPE))
    ]
    explained = tuple(Explanation(m, chi2, {}) for m, chi2 in zip(models, (1.0, 2.0, 5.0, 4.0), strict=True))
    plays: Any = None
    then = Reference(models[0], Observation.neutral(body), explained, unknown, unknown, plays, 0.003)
    tried: list[Model] = []

    def beside(baseline: Any) -> Any:
        tried.append(baseline.model)
        if baseline.model.effects:
            raise NoPath("g0r1")
        return baseline.model

    found, last = with_a_path(then, beside)
    assert tried == [models[0], models[3], models[2], models[1]]
    assert found == models[1]
    assert [e.model for e in last.explained] == [models[1]]  # type: ignore[attr-defined]
    assert len(last.remarks) == 3
    assert last.remarks[0] == (
        "the reference is explained by `frame_drift` and `slope`, not by `frame_drift`: steps of that model have no "
        "root along the shapes of trial `g0r1`"
    )
    assert "explained by eps alone, not by `slope`" in last.remarks[2]
    with pytest.raises(NoPath):
        with_a_path(replace(last, model=models[0], explained=explained[:1]), beside)
