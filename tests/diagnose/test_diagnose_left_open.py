"""Names under the doubt of their intervals, and beside changes that other stages name."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from serpenoid.body import Body
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.shapes.geometry import register, shapes, turn
from serpenoid.diagnose.diagnose import beside_changes
from serpenoid.diagnose.inference.doubt.left_open import believed, known
from serpenoid.diagnose.inference.fits.finding import Named, Stage
from serpenoid.diagnose.inference.fits.medium import Fit, predicted_bare
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.diagnose.report.drag import ratio_change
from serpenoid.diagnose.report.sentences import undetected
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.motion.choose_motion import MotionFinding, beside_earlier
from serpenoid.diagnose.stages.motion.stand_ins import explained
from serpenoid.diagnose.stages.observation.beside_markers import chi2_of_markers
from serpenoid.effects.active import ActiveEffect
from serpenoid.model import Model

BODY = Body(vertices=5, length_m=0.4)


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
    bare_of_it = predicted_bare(found.motion, found.settled)

    def beside(times: float) -> Selection:
        """What is believed beside an explanation by which it is so many times as large."""
        trios = zip(found.motion.tracks, found.settled.predictions, bare_of_it, strict=True)
        shown = (replace(t, offset=t.offset - (times - 1) * (p.displacement - q.displacement)) for t, p, q in trios)
        other = (replace(found.motion, tracks=tuple(shown)), times_as_large(found.settled, times), 1.0)
        return believed(found, lambda f: explained(f, inadequate=True, beside=(other,)))

    assert [e.key for e in beside(3.0).best.effects] == [name.key]  # how large it is they leave open, and no more
    bare = beside(-0.15)
    assert bare.best.effects == () == bare.bases
    assert bare.refused[0].effect.key == name.key
    assert bare.best.chi2 == pytest.approx(found.null.chi2)


def test_a_name_is_believed_for_its_value_where_it_takes_away_less_than_its_slope_says(
    diagnosed: tuple[Any, dict[str, Any], Any],
) -> None:
    """As of a wheel that bears nothing any more: the farther it is unloaded, the less that does."""
    found = diagnosed[0].motion.selection
    explanations = ((found.motion, found.settled, 1.0),)
    flat = replace(found, bases=tuple(replace(b, chi2=found.best.chi2 + 1.0) for b in found.bases))
    assert known(flat, explanations)[0][0] > 1
    assert believed(flat, lambda f: explanations) is flat


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
    (named,) = beside_changes(cast(Any, found), (above,), known, Observation.neutral(BODY)).stage.named
    assert named.stand_in is doubtful


def bent_otherwise(found: MotionFinding, joint: int, size: float) -> Selection:
    """Markers that show a joint bent by another angle, now to one side, now to the other."""
    selection, tracks = found.selection, []
    for t in found.selection.motion.tracks:
        r = t.recording
        assert isinstance(r, Recording)
        true = r.angles.copy()
        true[:, joint - 1] += size * np.sign(np.sin(3 * r.time))
        moved = shapes(r.body, true) - shapes(r.body, r.angles)
        pose, _ = register(shapes(r.body, r.angles), r.markers)
        tracks.append(replace(t, recording=replace(r, markers=r.markers + turn(pose[:, None, 2], moved))))
    return replace(selection, motion=replace(selection.motion, tracks=tuple(tracks)))


@pytest.mark.parametrize(("size", "doubtful"), [(0.0, False), (0.01, False), (1.0, True)])
def test_a_name_that_does_no_more_than_what_markers_leave_open_may_be_there_for_that(
    diagnosed: tuple[Any, dict[str, Any], Any], size: float, doubtful: bool
) -> None:
    """A joint is bent otherwise than its servo reads, and nothing explains it."""
    d, joint = diagnosed[0], 3
    found = replace(d.motion, selection=bent_otherwise(d.motion, joint, size))
    body = d.baseline.model.body
    news = [float(channel == joint - 1) for channel in range(body.joint_count + body.vertices - 1)]
    above = (Stage("observation", news=tuple(news)),)
    (name,) = beside_changes(found, above, d.baseline, d.seen).stage.named
    assert name.stand_in is doubtful


def test_what_markers_show_of_a_bent_joint_moves_the_ends_of_windows_in_proportion(
    diagnosed: tuple[Any, dict[str, Any], Any],
) -> None:
    d, body = diagnosed[0], diagnosed[0].baseline.model.body
    news = [float(channel == 2) for channel in range(body.joint_count + body.vertices - 1)]
    none, one, two = (chi2_of_markers(bent_otherwise(d.motion, 3, s), d.seen, news) for s in (0.0, 0.1, 0.2))
    assert none < 0.01 * one  # noise
    assert two == pytest.approx(4 * one, rel=0.2)


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


@dataclass(frozen=True)
class Earlier:
    """A reference whose guess at a load may be off by so much, less and more."""

    off: float

    def doubt_of(self, effect: ActiveEffect) -> np.ndarray:
        return np.array([[-self.off, self.off]])


def test_a_guess_about_the_reference_puts_a_value_in_doubt_and_not_that_it_has_changed() -> None:
    """By what was measured beside it, a load changed by 0.1 to 0.5; how much there is of it now is not known."""
    load = ActiveEffect.of("load", 3, share=0.3)
    changed = Named(load, {"share": (0.1, 0.5)}, 4.0, stand_in=True)
    stage = beside_earlier(Stage("motion", (changed,)), cast(Baseline, Earlier(0.2)))
    (named,) = stage.named
    assert named.intervals["share"] == pytest.approx((-0.1, 0.7))
    assert stage.undetected == ()
    open_ = Named(load, {"share": (-0.1, 0.5)}, 4.0, stand_in=True)  # by what was measured alone
    stage = beside_earlier(Stage("motion", (open_,)), cast(Baseline, Earlier(0.0)))
    assert (stage.named, stage.undetected) == ((), (open_,))
