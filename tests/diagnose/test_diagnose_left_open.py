"""Names under the doubt of their intervals, and beside changes that other stages name."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, cast

import pytest

from serpenoid.diagnose.diagnose import beside_changes
from serpenoid.diagnose.inference.finding import Named, Stage
from serpenoid.diagnose.inference.left_open import believed, known
from serpenoid.diagnose.inference.medium import Fit, predicted_bare
from serpenoid.diagnose.report.sentences import ratio_change, undetected
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.choose_motion import explained
from serpenoid.effects.active import ActiveEffect
from serpenoid.model import Model


def times_as_large(fit: Fit, factor: float) -> Fit:
    model = fit.model
    larger = tuple(e.with_coordinates([factor * c for c in e.coordinates[:-1]]) for e in model.effects)
    return replace(fit, model=Model(model.body, model.medium, larger))


def test_a_name_that_explanations_of_the_law_leave_open_is_refused(diagnosed: tuple[Any, dict[str, Any], Any]) -> None:
    found = diagnosed[0].motion.selection
    (name,) = found.best.effects
    same = believed(found, lambda f: explained(f, inadequate=True))
    assert [e.key for e in same.best.effects] == [name.key]
    assert believed(found, lambda f: explained(f, inadequate=False)) is found
    predicted = zip(
        found.motion.tracks, found.settled.predictions, predicted_bare(found.motion, found.settled), strict=True
    )
    tracks = tuple(replace(t, offset=t.offset - 2 * (p.displacement - q.displacement)) for t, p, q in predicted)
    other = ((replace(found.motion, tracks=tracks), times_as_large(found.settled, 3.0), 1.0),)  # three times as much
    bare = believed(found, lambda f: explained(f, inadequate=True, beside=other))
    assert bare.best.effects == () == bare.bases
    assert bare.refused[0].effect.key == name.key
    assert bare.best.chi2 == pytest.approx(found.null.chi2)


def test_a_value_that_data_push_beyond_its_bound_is_no_finding(
    diagnosed: tuple[Any, dict[str, Any], Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    found = diagnosed[0].motion.selection
    (name,) = found.best.effects
    (value,) = name.coordinates[:-1]
    monkeypatch.setattr(type(name.effect), "coordinate_bounds", lambda *_: [(0.0, value)])
    gained, beyond = known(found, ((found.motion, found.settled, 1.0),))
    assert gained[0] > 1 > beyond[0]
    bare = predicted_bare(found.motion, found.settled)
    trios = zip(found.motion.tracks, found.settled.predictions, bare, strict=True)
    tracks = tuple(replace(t, offset=t.offset - (p.displacement - q.displacement)) for t, p, q in trios)
    twice = replace(found, motion=replace(found.motion, tracks=tracks))  # shows the effect twice as large
    refused = believed(twice, lambda f: ((f.motion, f.settled, 1.0),)).refused[0]
    assert (refused.effect.key, refused.beyond) == (name.key, True)
    monkeypatch.undo()
    assert believed(twice, lambda f: ((f.motion, f.settled, 1.0),)) is twice


@dataclass(frozen=True)
class SimpleStage:
    stage: Stage


def stage_of(name: str, place: int | None = None) -> Stage:
    return Stage(ActiveEffect.neutral(name, place).effect.site, (Named(ActiveEffect.neutral(name, place), {}, 5.0),))


@pytest.mark.parametrize(
    ("above", "ratio", "inadequate", "doubtful"),
    [
        (stage_of("stuck_joint", 3), 0.1, True, True),
        (stage_of("zero_offset", 3), 0.1, True, True),
        (stage_of("marker_offset", 3), 0.1, True, False),  # the body's shapes are what they were
        (stage_of("stuck_joint", 3), 0.1, False, False),
        (stage_of("stuck_joint", 3), None, True, False),
    ],
)
def test_a_change_of_shapes_that_another_stage_names_puts_names_of_the_floor_in_doubt(
    above: Stage, ratio: float | None, inadequate: bool, doubtful: bool
) -> None:
    slope = Named(ActiveEffect.neutral("slope"), {}, 5.0)
    found = SimpleStage(Stage("motion", (slope,)))
    known = cast(Baseline, SimpleNamespace(ratio=ratio, inadequate=inadequate))
    (named,) = beside_changes(cast(Any, found), (above,), known).stage.named
    assert named.stand_in is doubtful


def test_a_changed_anisotropy_ratio_is_told_of_by_how_much_and_how_visibly() -> None:
    change = {"before": 0.0571, "after": 0.0056, "factor": 0.0981, "strength_over_noise": 12.0}
    said, _ = ratio_change({"anisotropy_ratio": {"change": change}})
    assert said.startswith("the anisotropy ratio is smaller by a factor of 10.2 than in the reference (12")
    assert ratio_change({"anisotropy_ratio": {"change": None}}) == []
    assert ratio_change({"anisotropy_ratio": {}}) == []  # of an older answer


def test_what_leaves_no_trace_is_not_listed() -> None:
    weak = {"name": "load", "place": 3, "in_extended_model": False}
    listed = [weak | {"strength_over_noise": x} for x in (0.0, 0.04, 0.3)]
    assert undetected({"below_detection": listed}) == ["load at vertex 3 (0.3 times the noise)"]
