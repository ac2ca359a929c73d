"""Names of both signs beside a number of the law at its limit, or at the two ends: stand-ins for another law, and
nothing is explained."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest

from serpenoid.diagnose.diagnose import verdict
from serpenoid.diagnose.inference.doubt.other_law import of_another_law
from serpenoid.diagnose.inference.fits.finding import Named, Stage
from serpenoid.diagnose.report.verdicts import inadequacy
from serpenoid.diagnose.stages.motion import stand_ins
from serpenoid.diagnose.stages.motion.choose_tracked import ASIDE
from serpenoid.diagnose.stages.motion.stand_ins import another_law, beside_paths
from serpenoid.effects.active import ActiveEffect
from serpenoid.medium import Medium
from serpenoid.wording import OF_SHAPES, OTHER_LAW

MEDIUM = Medium(anisotropy_ratio=0.4)
VERTICES = 12
WITHIN, TO_ONE = (0.38, 0.42), (0.92, 1.0)


def load(vertex: int, share: float) -> Named:
    return Named(ActiveEffect.of("load", vertex, share=share), {"share": (share - 0.01, share + 0.01)}, 5.0)


def power(low: float, value: float, high: float) -> Named:
    return Named(ActiveEffect.of("power_law_drag", exponent=value), {"exponent": (low, high)}, 20.0)


BOTH = (load(1, -0.03), load(5, 0.04))
DRY = power(0.0, 0.01, 0.04)


@pytest.mark.parametrize(
    ("named", "ratio", "said"),
    [
        (BOTH, TO_ONE, True),
        ((*BOTH, DRY), WITHIN, True),  # drag with the exponent of dry friction
        (BOTH, WITHIN, False),  # modules that weigh what nobody states
        ((*BOTH, power(0.1, 0.2, 0.3)), WITHIN, False),
        ((*BOTH, power(0.9, 0.95, 1.0)), WITHIN, False),  # what changes nothing is no limit
        ((load(1, 0.03), load(5, 0.04), DRY), TO_ONE, False),  # two loads
        ((load(1, -0.03), DRY), TO_ONE, False),
        ((DRY,), TO_ONE, False),
        ((load(0, 0.012), load(11, -0.014)), WITHIN, True),  # contacts that stand behind the joints do as much
        ((load(0, 0.012), load(11, 0.014)), WITHIN, False),  # two heavy ends
        ((load(0, 0.012), load(10, -0.014)), WITHIN, False),
        ((load(0, 0.012), load(5, 0.03), load(11, -0.014)), WITHIN, False),  # modules of other weights
    ],
)
def test_both_signs_and_a_limit_or_the_two_ends_are_needed(
    named: tuple[Named, ...], ratio: tuple[float, float], said: bool
) -> None:
    why = of_another_law(MEDIUM, VERTICES, named, ratio)
    assert bool(why) == said
    assert not said or why.endswith(OTHER_LAW)


def test_limits_are_those_that_the_medium_states() -> None:
    bounded = Medium(anisotropy_ratio=0.4, anisotropy_ratio_bounds=(0.3, 0.42))
    assert "the anisotropy ratio" in of_another_law(bounded, VERTICES, BOTH, WITHIN)


def test_such_names_are_stand_ins_and_explain_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stand_ins, "ratio_interval", lambda found, stage: TO_ONE)
    found = SimpleNamespace(motion=SimpleNamespace(ratio=None), settled=SimpleNamespace(model=SimpleNamespace()))
    found.settled.model.medium, found.settled.model.body = MEDIUM, SimpleNamespace(vertices=VERTICES)
    stage = Stage("motion", BOTH)
    assert verdict([stage]) == "explained"
    marked = another_law(found, stage)  # type: ignore[arg-type]
    assert all(n.stand_in for n in marked.named)
    assert verdict([marked]) == "partly explained"
    found.motion.ratio = 0.4  # beside a reference eps is given, and loads are changes
    assert another_law(found, stage) == stage  # type: ignore[arg-type]
    doubted = replace(stage, named=tuple(replace(n, stand_in=True) for n in BOTH))
    found.motion.ratio = None
    assert another_law(found, doubted) == doubted  # type: ignore[arg-type]


def test_it_is_said_why_they_are_in_doubt() -> None:
    why = f"motion: {of_another_law(MEDIUM, VERTICES, BOTH, TO_ONE)}"
    effects = [{"name": "load", "place": 1, "site": "medium", "stand_in": True}]
    record = {"effects": effects, "discrepancy_m": 0, "residual_pattern": [why], "verdict": "partly explained"}
    assert "at some places what they give at others" in inadequacy(record)[0]


def test_beside_a_point_that_is_off_the_midline_it_is_not_said_that_paths_are_off() -> None:
    words = [f"motion: {ASIDE} (point 4 from the tail): {OF_SHAPES}"]
    effects = [{"name": "load", "place": 1, "site": "medium", "stand_in": True}]
    record = {"effects": effects, "discrepancy_m": 0, "residual_pattern": words, "verdict": "partly explained"}
    why = inadequacy(record | {"noise_from": "points", "reference": None})[0]
    assert why.startswith("a point beside the midline bends the shapes")


def test_what_does_less_than_is_left_of_paths_may_be_a_part_of_that() -> None:
    few, paths = load(3, 0.1), 2.3  # times the noise, which so few windows may make by chance
    weak, strong = replace(few, strength=1.2), replace(few, strength=5.0)
    assert [n.stand_in for n in beside_paths([weak, strong], paths)] == [True, False]
    assert not beside_paths([weak], 1.4)[0].stand_in
