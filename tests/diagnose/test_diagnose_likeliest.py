"""Of what a search came by, the likeliest is kept: beside a law that is wrong, more effects mend the law alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, Effect, make
from blind.folder import write
from blind.windows import windows
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.shared import discrepancy
from serpenoid.diagnose.inference.fits.medium import TO_THE_END, Fit, fit, fit_eps
from serpenoid.diagnose.inference.search.select import calibrated, likeliest
from serpenoid.diagnose.inference.search.tries import at_other_places, attempts
from serpenoid.effects.active import ActiveEffect

WHEEL = ("worn_wheel", 7)
HEAP = [WHEEL, ("load", 2), ("load", 9)]
LAW = Effect("rolling_resistance", None, {"crossover_speed": 0.02})


def explanations(folder: Path, law: Sequence[Effect], seizure: float = 0.5, gaits: int = 3) -> tuple[Motion, list[Fit]]:
    """The motion of a robot with a worn wheel, and fits of the wheel, and of a heap, without the law."""
    campaign = make(5, [*law, Effect(*WHEEL, {"seizure": seizure})], "law", COMBINATIONS[:gaits])
    write(campaign, folder)
    motion, model = windows(folder, campaign.eps)

    def of(keys: Sequence[tuple[str, int]]) -> Fit:
        effects = [ActiveEffect.neutral(*key) for key in keys]
        start = np.array([campaign.eps, *(e.coordinates[0] for e in effects)])
        return fit(motion, model, effects, start, TO_THE_END)

    motion, alone = calibrated(motion, of([WHEEL]))
    return motion, [alone, of(HEAP)]


@pytest.mark.slow
def test_beside_a_law_that_is_wrong_the_cause_is_likelier_than_a_heap(tmp_path: Path) -> None:
    motion, (alone, heap) = explanations(tmp_path, [LAW])
    assert discrepancy(motion, heap.predictions) > 0
    assert heap.chi2 < alone.chi2
    found = likeliest(motion, heap, [alone, heap])
    assert [e.key for e in found.effects] == [WHEEL]
    assert found.coordinates[1] == pytest.approx(0.5, abs=0.05)
    assert likeliest(motion, alone, [alone, heap]) is alone


@pytest.mark.slow
def test_of_an_effect_that_is_large_all_places_are_tried_from_where_it_was_fitted(tmp_path: Path) -> None:
    """First order about neutral tells neither how much a seized wheel does nor which one it is."""
    motion, (alone, _) = explanations(tmp_path, [LAW], seizure=0.98)
    null = fit_eps(motion, replace(alone.model, effects=()))
    near = ActiveEffect.neutral("worn_wheel", 5)
    start = np.array([null.coordinates[0], 0.9])
    (found,) = attempts(motion, null, [(near, 0.0, start)])
    assert found.fitted.parameters["seizure"] > 0.5
    others = at_other_places(motion, null, [found])
    assert {e.place for e, _, _ in others} == {*range(12)} - {5}
    assert all(e.name == "worn_wheel" and x[1] == found.fitted.coordinates[0] for e, _, x in others)
    best = min(attempts(motion, null, others), key=lambda t: t.fit.chi2)
    assert best.fitted.key == WHEEL
    assert at_other_places(motion, null, []) == []
    little = replace(found, fit=fit(motion, null.model, [near], np.array([start[0], 0.1]), 0))
    assert at_other_places(motion, null, [little]) == []


def test_where_the_law_is_right_the_search_has_the_last_word(tmp_path: Path) -> None:
    motion, (alone, heap) = explanations(tmp_path, [], gaits=2)
    assert discrepancy(motion, alone.predictions) == 0
    assert likeliest(motion, heap, [alone, heap]) is heap
