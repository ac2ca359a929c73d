"""Dry friction beside linear drag: told of wherever it misses less, and taken where it is the law."""

from __future__ import annotations

from dataclasses import replace
from itertools import count
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.folder import write
from serpenoid.body import Floats
from serpenoid.diagnose import drag_ratio as told_ratio
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import held_out_labels
from serpenoid.diagnose.data.windows.tracks import make_tracks
from serpenoid.diagnose.diagnose import Diagnosis
from serpenoid.diagnose.drag_ratio import drag_ratio_of
from serpenoid.diagnose.inference.doubt import laws
from serpenoid.diagnose.inference.doubt.laws import by_its_own_numbers, on_rival, rival_laws
from serpenoid.diagnose.inference.fits.finding import Stage
from serpenoid.diagnose.inference.fits.medium import Fit, coordinates_of, fit, fit_eps, linearised
from serpenoid.diagnose.inference.search.select import Selection, calibrated
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.motion.choose_motion import GUESS, MotionFinding, choose_on_tracks
from serpenoid.diagnose.stages.motion.law_of_medium import slipping_sideways
from serpenoid.diagnose.start import baseline
from serpenoid.effects.active import ActiveEffect
from serpenoid.media import LAWS
from serpenoid.medium import Medium
from serpenoid.model import Model

EPS = 0.2


@pytest.fixture(scope="module")
def dragged(tmp_path_factory: pytest.TempPathFactory) -> tuple[Motion, Fit]:
    """Two gaits on a floor of linear drag, and eps alone."""
    folder = tmp_path_factory.mktemp("drag")
    write(make(5, [], "drag", COMBINATIONS[:2]), folder)
    file, recordings = read_recordings(folder)
    known = Baseline(baseline(None, file, file.body))
    tracks = make_tracks(recordings, known.observation(), known.model)
    motion = Motion(tracks, GUESS, held_out_labels(recordings), (), np.zeros(3), frozenset(), None)
    return calibrated(motion, fit_eps(motion, known.model))


def asked(motion: Motion, null: Fit, law: str = "coulomb") -> str:
    found = rival_laws(Selection(null, (), null, (), (), motion, null, 1.0, ())).get(law)
    return "" if found is None else found.words


def slid(motion: Motion, null: Fit, other: Model) -> Motion:
    """The same shapes as another law moves them: what the fit leaves is what is left of it."""
    predicted = linearised(motion, other, [])[1]
    moved = [
        replace(t, offset=t.offset + p.displacement - q.displacement)
        for t, p, q in zip(motion.tracks, null.predictions, predicted, strict=True)
    ]
    return replace(motion, tracks=tuple(moved))


def on_dry(dragged: tuple[Motion, Fit]) -> tuple[Motion, Fit]:
    """The same shapes on dry friction, and eps alone of linear drag."""
    motion, null = dragged
    dry = on_rival(null.model, LAWS["coulomb"])
    assert dry is not None
    motion = slid(motion, null, replace(dry, medium=Medium(anisotropy_ratio=EPS, law="coulomb")))
    return motion, fit_eps(motion, null.model)


def test_a_body_that_moves_the_way_its_bends_run_has_a_ratio_above_one(dragged: tuple[Motion, Fit]) -> None:
    motion, null = dragged
    sideways = Medium(anisotropy_ratio=3.0, anisotropy_ratio_bounds=(1.0, 10.0))
    slips = slid(motion, null, replace(null.model, medium=sideways))
    begun = Baseline(null.model)
    found = slipping_sideways(begun, lambda known: (slips, fit_eps(slips, known.model)))
    assert found.model.medium.anisotropy_ratio == pytest.approx(3.0, rel=0.02)
    assert slipping_sideways(begun, lambda known: (motion, fit_eps(motion, known.model))) is begun
    water = null.model.medium.model_copy(update={"anisotropy_ratio_bounds": (0.1, 1.0)})
    told = Baseline(replace(null.model, medium=water))
    assert slipping_sideways(told, lambda known: (slips, fit_eps(slips, known.model))) is told


@pytest.mark.slow
def test_dry_friction_is_told_of_where_it_is_the_law(dragged: tuple[Motion, Fit]) -> None:
    assert asked(*on_dry(dragged)).startswith("dry friction (Coulomb) misses windows by 1.0 times the noise")


@pytest.mark.slow
def test_quadratic_drag_is_told_of_where_it_is_the_law(dragged: tuple[Motion, Fit]) -> None:
    motion, null = dragged
    quick = on_rival(null.model, LAWS["quadratic"])
    assert quick is not None
    motion = slid(motion, null, replace(quick, medium=Medium(anisotropy_ratio=EPS, law="quadratic")))
    assert asked(motion, fit_eps(motion, null.model), "quadratic").startswith(
        "quadratic drag misses windows by 1.0 times the noise"
    )


@pytest.mark.slow
def test_a_law_that_leaves_more_than_what_is_named_is_told_so(
    dragged: tuple[Motion, Fit], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Dry friction by the plain speed: nearer than drag alone, and farther than drag with stand-ins."""
    monkeypatch.setattr(laws, "misses", lambda *_: [62.1, 5.3, 18.6, 12.7])
    said = asked(*on_dry(dragged))
    assert "by 18.6 times the noise and linear drag by 62.1" in said
    assert "the medium may follow neither" in said


@pytest.mark.parametrize(
    ("loads", "by_itself", "searched"),
    [
        pytest.param((), 4.0, False, marks=pytest.mark.slow),  # as drag with what is named leaves less, needs little
        pytest.param((3,), 4.0, False, marks=pytest.mark.slow),
        ((1, 3), 4.0, True),
        ((1, 3), 40.0, False),  # more than a third of what drag leaves
    ],
)
def test_beside_the_nearest_law_names_are_looked_for_where_drag_needs_one_effect_at_several_places(
    loads: tuple[int, ...],
    by_itself: float,
    searched: bool,
    dragged: tuple[Motion, Fit],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    motion, null = on_dry(dragged)
    effects = [ActiveEffect.of("load", vertex, share=0.01) for vertex in loads]
    best = fit(motion, null.model, effects, coordinates_of(null.model, effects), 0)
    more = count()
    monkeypatch.setattr(laws, "misses", lambda *_: [62.1, 1.2, by_itself + next(more), 3.0])
    found = rival_laws(Selection(best, (), best, (), (), motion, null, 1.0, ()))
    assert [r.promising for r in sorted(found.values(), key=lambda r: r.alone)] == [
        searched,
        *[False] * (len(found) - 1),
    ]


def test_dry_friction_is_judged_as_who_follows_the_advice_will_have_it(
    dragged: tuple[Motion, Fit], monkeypatch: pytest.MonkeyPatch
) -> None:
    judged: list[float] = []
    found = laws.misses

    def noted(motion: Motion, fits: list[tuple[object, Fit]]) -> list[float]:
        judged.extend(f.model.medium.softening for _, f in fits[2:])
        return found(motion, fits)

    monkeypatch.setattr(laws, "misses", noted)
    assert asked(*on_dry(dragged))
    assert set(judged) == {Medium(anisotropy_ratio=0.5).softening}


def test_where_steps_lose_their_roots_on_the_way_a_fit_is_begun_nearer(
    dragged: tuple[Motion, Fit], monkeypatch: pytest.MonkeyPatch
) -> None:
    reach, fitted = 1.2, laws.fit

    def stopped(motion: Motion, model: Model, effects: list[ActiveEffect], x: Floats, steps: int) -> Fit:
        return fitted(motion, model, effects, x, steps if EPS / reach < x[0] < EPS * reach else 0)

    monkeypatch.setattr(laws, "fit", stopped)
    assert asked(*on_dry(dragged)).startswith("dry friction (Coulomb) misses windows by 1.0 times the noise")


def test_on_a_floor_of_linear_drag_nothing_is_said_of_dry_friction(dragged: tuple[Motion, Fit]) -> None:
    assert asked(*dragged) == ""


def test_the_ratio_of_a_law_that_a_file_states_is_fitted_and_no_other_law_is_asked_for(
    dragged: tuple[Motion, Fit],
) -> None:
    motion, null = dragged
    fast = replace(null.model, medium=Medium(anisotropy_ratio=EPS, law="quadratic"))
    motion = slid(motion, null, fast)
    _, found = calibrated(motion, fit_eps(motion, replace(fast, medium=fast.medium.with_ratio(0.4))))
    assert found.model.medium.anisotropy_ratio == pytest.approx(EPS, abs=0.01)  # the noise of the markers
    assert asked(motion, found) == ""


def creeping(law: str, motion: Motion, null: Fit) -> tuple[Motion, Model]:
    """The same shapes on dry friction that creeps below 8 mm/s, rather suddenly."""
    dry = on_rival(null.model, LAWS[law])
    assert dry is not None
    creep = ActiveEffect.of("creep", creep_speed=0.008, sharpness=2.7)
    model = replace(dry, medium=Medium(anisotropy_ratio=EPS, law=law), effects=(creep,))
    return slid(motion, null, model), model


@pytest.mark.parametrize("law", ["coulomb", "coulomb_by_components", "coulomb_plain"])
def test_the_numbers_of_a_law_are_found_with_eps(law: str, dragged: tuple[Motion, Fit]) -> None:
    motion, truth = creeping(law, *dragged)
    found = by_its_own_numbers(motion, replace(truth, effects=()), 0.01)
    deviations = np.sqrt(np.diag(np.linalg.inv(found.evidence.matrix.sum(axis=0))))
    assert (np.abs(found.coordinates - [EPS, 0.008, 2.7]) < 4 * deviations).all()
    assert (deviations[:2] < [0.002, 0.002]).all()


@pytest.mark.parametrize(
    ("law", "law_open"),
    [("coulomb", True), ("coulomb_by_components", True), ("coulomb", False)],  # effects make the plain slip of drag
)
@pytest.mark.slow
def test_a_law_that_nobody_states_is_taken_where_it_leaves_little_and_drag_much(
    law: str, law_open: bool, dragged: tuple[Motion, Fit]
) -> None:
    motion, null = dragged
    moved, _ = creeping(law, motion, null)
    known = Baseline(null.model, law_open=law_open)
    found = choose_on_tracks(lambda about: moved.tracks, motion.labels, known, lambda text: None)
    taken = found.selection.best.model.medium.law
    assert taken == (law if law_open else "viscous")
    assert bool(found.stage.law_taken) == law_open
    if law_open:
        assert "it is taken with creep_speed 0.00" in found.stage.law_taken
        assert not found.stage.named
        assert {e.name for e in found.baseline.known} == {"creep"}  # type: ignore[union-attr]
        assert found.selection.best.model.medium.anisotropy_ratio == pytest.approx(EPS, rel=0.01)
        ratio = drag_ratio_of(answered(found), campaign=None, begun=null.model.medium)  # type: ignore[arg-type]
        assert ratio.low < 1 / EPS < ratio.high < 1.03 * ratio.low
        assert ratio.value == 1 / found.selection.settled.model.medium.anisotropy_ratio
        assert not ratio.by_frames  # `fit` knows nothing of creep
    else:
        assert law in found.stage.laws


def answered(found: MotionFinding) -> Diagnosis:
    """As much of a diagnosis as K is told by."""
    return cast(Diagnosis, SimpleNamespace(motion=found, named=found.stage.named))


def test_k_of_a_law_without_numbers_of_its_own_is_that_of_a_fit_by_this_law(
    dragged: tuple[Motion, Fit], monkeypatch: pytest.MonkeyPatch
) -> None:
    motion, null = dragged
    quick = on_rival(null.model, LAWS["quadratic"])
    assert quick is not None
    alone = replace(null, model=quick)
    found = Selection(alone, (), alone, (), (), motion, alone, 1.0, ())
    asked_of: list[Model] = []

    def fitted(campaign: object, model: Model) -> Any:
        asked_of.append(model)
        return SimpleNamespace(names=("anisotropy_ratio",), values=np.array([0.25]))

    monkeypatch.setattr(told_ratio, "anisotropy", fitted)
    monkeypatch.setattr(told_ratio, "drag_ratio", lambda found, model: (4.0, 3.9, 4.1))
    answer = answered(MotionFinding(Stage("motion"), found, (), 1.0, 1.0))
    ratio = drag_ratio_of(answer, SimpleNamespace(body=null.model.body), Medium(anisotropy_ratio=0.4))  # type: ignore[arg-type]
    assert ratio == told_ratio.DragRatio(4.0, 3.9, 4.1, by_frames=True)
    assert [(m.medium.law, m.medium.anisotropy_ratio) for m in asked_of] == [("quadratic", 0.4)]


def test_on_linear_drag_no_other_law_is_taken(dragged: tuple[Motion, Fit]) -> None:
    motion, null = dragged
    known = Baseline(null.model, law_open=True)
    found = choose_on_tracks(lambda about: motion.tracks, motion.labels, known, lambda text: None)
    assert found.selection.best.model.medium.law == "viscous"
    assert not found.stage.law_taken
