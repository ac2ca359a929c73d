"""What a fit says of itself: a bound where the data are followed is an answer; of a wrong model no interval holds."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from rehearsal import snake
from serpenoid.body import Body
from serpenoid.compare.complaints import complaints, failed
from serpenoid.medium import Medium
from serpenoid.model import Model

NAMES = ("anisotropy_ratio",)


def fitted(value: float, noise_scale: float, converged: bool = True) -> SimpleNamespace:
    return SimpleNamespace(
        names=NAMES, values=np.array([value]), converged=converged, noise_scale=noise_scale, freedom=1000
    )


def said(value: float, noise_scale: float, trials: int = 1, model=None) -> str:
    solution = fitted(value, noise_scale)
    interval = value + 1e-3 * np.array([[-1, 1]])
    return " | ".join(complaints(solution, model or snake(), np.array([1e-3]), interval, np.eye(1), trials))


def test_a_bound_at_which_the_data_are_followed_is_an_answer():
    text = said(1.0, 1.04)
    assert "follows these data" in text
    assert "cannot" not in text
    assert "ran into" not in text


def test_a_body_that_moves_the_way_its_bends_run_is_told_that_the_model_has_no_such():
    text = said(1.0, 394.7)
    assert "ran into its bound 1" in text
    assert "K < 1" in text
    assert "K < 1" not in said(1e-4, 394.7)


@pytest.mark.parametrize(
    ("kind", "bounds", "value", "told"),
    [("swimmer", None, 0.035, True), ("swimmer", None, 0.6, False), ("swimmer", None, 0.4995, False),
     ("swimmer", (0.01, 1.0), 0.035, False), ("crawler", None, 0.035, False)],
)  # fmt: skip
def test_a_swimmer_whose_drag_no_water_has_is_told_what_keeps_it_within(kind, bounds, value, told):
    model = snake()
    medium = Medium(anisotropy_ratio=0.3, anisotropy_ratio_bounds=bounds)
    text = said(value, 1.0, model=replace(model, body=model.body.model_copy(update={"kind": kind}), medium=medium))
    assert ("K is above 2" in text and "anisotropy_ratio_bounds = [0.5, 1]" in text) == told


@pytest.mark.parametrize("trials", [1, 4])
def test_a_wrong_model_is_told_that_its_intervals_say_nothing(trials):
    text = said(0.3, 11.0, trials)
    assert "the model is wrong somewhere, and intervals hold only if it is right" in text
    assert ("what trials differ by" in text) == (trials > 1)
    assert ("another law of drag" in text) == snake().law.linear
    assert not said(0.3, 1.0, trials)


def test_of_an_animal_a_body_beyond_its_points_and_a_drift_may_be_it_too():
    animal = Model(Body(kind="crawler", vertices=12, edge_lengths=(1 / 11,) * 11), snake().medium)
    for text, told in ((said(0.3, 11.0, model=animal), True), (said(0.3, 11.0), False)):
        assert ("beyond its outermost points" in text) == told
        assert ("drifts" in text) == told


@pytest.mark.parametrize(
    ("value", "noise_scale", "converged", "fails"),
    [(0.3, 1.0, True, False), (0.3, 11.0, True, False), (1.0, 1.04, True, False), (1.0, 11.0, True, True),
     (0.3, 1.0, False, True)],
)  # fmt: skip
def test_a_fit_fails_that_did_not_converge_or_ran_into_a_bound_beyond_which_data_lead(
    value, noise_scale, converged, fails
):
    assert failed(fitted(value, noise_scale, converged), snake()) == fails
