"""Where nothing was played twice, chance is what is left: first-order scores are in units of the model's own error."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from blind.campaign import make
from blind.catalogue import Effect
from blind.folder import write
from blind.random_protocols import draw_protocol, once
from serpenoid.diagnose.campaign import diagnose_campaign
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.inference.fits.finding import Named, Stage
from serpenoid.diagnose.inference.fits.medium import Fit
from serpenoid.diagnose.residuals.gain import Scores
from serpenoid.diagnose.stages.actuation.choose_actuation import choose_actuation
from serpenoid.diagnose.stages.actuation.choose_set_points import plays
from serpenoid.diagnose.stages.motion import borne_out, choose_motion, stand_ins
from serpenoid.diagnose.stages.motion.ratio_change import RatioChange
from serpenoid.effects.active import ActiveEffect

SEED = 166611063688274
HIDDEN = (
    Effect("rolling_resistance", None, {"crossover_speed": 0.44655}),
    Effect("wheel_mount", None, {"share": -0.6711}),
)


NOISY_SEED = 101779083490935  # markers alone, 7 mm of noise, five trials: how large noise is, is known to a tenth


@pytest.mark.slow
def test_rows_that_run_are_not_taken_to_jump_and_servos_to_lag_where_markers_are_noisy(tmp_path: Path) -> None:
    """No way to take the rows is followed within a noise that is underestimated; the best is so by chance."""
    write(make(NOISY_SEED, [], "noisy", protocol=once(draw_protocol(NOISY_SEED))), tmp_path)
    data = plays(read_recordings(tmp_path)[1])
    assert not data.held
    assert not choose_actuation(data).named


@pytest.mark.slow
def test_a_law_that_first_order_scores_do_not_show_is_found_without_repeats(tmp_path: Path) -> None:
    """Two trials of one cycle each; the wheels' mount, named alone, left held-out paths astray by 41 noise levels."""
    write(make(SEED, HIDDEN, "once", protocol=once(draw_protocol(SEED))), tmp_path)
    _, found = diagnose_campaign(tmp_path, None)
    assert {n.effect.name for n in found.named} == {e.name for e in HIDDEN}
    for named in found.named:
        (parameter,) = named.effect.parameters
        true = next(e for e in HIDDEN if e.name == named.effect.name).parameters[parameter]
        low, high = named.intervals[parameter]
        assert low is not None
        assert high is not None
        assert low < true < high


@pytest.mark.parametrize(
    ("over_markers", "strength", "marked"),
    [(1.05, 0.5, False), (9.0, 1.6, True), (9.0, 2.9, True), (9.0, 3.1, False), (1.2, 1.6, True), (1.2, 1.7, False)],
)
def test_names_that_may_be_parts_of_what_is_left_are_marked(
    over_markers: float, strength: float, marked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """(1 - 1 / 1.2^2)^(1/2) = 0.553 of what is left is none of the markers' noise: a third of 1.66."""
    monkeypatch.setattr(stand_ins, "over_markers", lambda _: over_markers)
    monkeypatch.setattr(stand_ins, "noise_uncertain", lambda _: 0.01)  # chance makes 1.1 of 1.0 at most
    floor = Named(ActiveEffect.typical("slope"), {}, strength)
    servo = Named(ActiveEffect.typical("servo_lag"), {}, strength)
    of_floor, of_servo = stand_ins.beside_what_is_left(cast(Motion, None), [floor, servo])
    assert of_floor.stand_in == marked
    assert not of_servo.stand_in  # the motion says nothing of servos


@pytest.mark.parametrize(
    ("after", "unrepeated", "marked"),
    [(0.012, True, False), (0.014, True, True), (0.014, False, False)],
)
def test_names_that_other_gaits_do_not_bear_out_are_marked_where_nothing_was_played_twice(
    after: float, unrepeated: bool, marked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Held-out paths stray by 12 mm without them, the noise is 3 mm, other gaits leave 4 mm open: 13 mm at most."""
    monkeypatch.setattr(borne_out, "left_open", lambda *_: np.array([0.004]))
    stage = Stage("motion", (Named(ActiveEffect.typical("slope"), {}, 2.0),))
    selection = SimpleNamespace(motion=SimpleNamespace(unrepeated=unrepeated), noise_level_m=0.003)
    found = choose_motion.MotionFinding(stage, cast(Any, selection), (), 0.0, 0.0)
    paths = [cast(Scores, SimpleNamespace(path=np.array([x]))) for x in (0.012, after)]
    judged = borne_out.borne_out(found, cast(Fit, None), *paths).stage
    assert [n.stand_in for n in judged.named] == [marked]
    assert judged.settled != marked


@pytest.mark.parametrize(
    ("strength", "unrepeated", "told"), [(2.4, True, True), (3.1, True, False), (2.4, False, False)]
)
def test_a_change_of_eps_that_leaves_a_third_of_itself_is_not_all_where_nothing_was_played_twice(
    strength: float, unrepeated: bool, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(borne_out, "beyond_markers", lambda _: 1.0)
    found = with_noise(monkeypatch, unrepeated)
    judged = borne_out.beside_another_ratio(found, RatioChange(0.14, 0.37, strength), cast(Any, Extension()), 0.0).stage
    assert judged.settled != told


class Extension:
    predictions = ()


def with_noise(monkeypatch: pytest.MonkeyPatch, unrepeated: bool) -> choose_motion.MotionFinding:
    """Of 1 mm, at most twice that by chance, beside 1.5 mm that other gaits leave open: 2.5 mm together."""
    monkeypatch.setattr(borne_out, "left_open", lambda *_: np.array([0.0015]))
    monkeypatch.setattr(borne_out, "path_noise", lambda *_: SimpleNamespace(farthest=2.0))
    selection = SimpleNamespace(motion=SimpleNamespace(unrepeated=unrepeated), noise_level_m=0.001)
    return choose_motion.MotionFinding(Stage("motion"), cast(Any, selection), (), 0.0, 0.0)


@pytest.mark.parametrize(("held_out_mm", "settled"), [(2.4, True), (2.6, False)])
def test_a_change_of_eps_that_other_gaits_do_not_bear_out_may_make_up_for_another(
    held_out_mm: float, settled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A seized wheel of a rigid-body robot was told as another eps: each gait by itself, and none by the others."""
    found = with_noise(monkeypatch, unrepeated=False)
    change = RatioChange(0.09, 0.11, 5.5)
    judged = borne_out.beside_another_ratio(found, change, cast(Any, Extension()), held_out_mm / 1e3).stage
    assert judged.settled == settled
    named = replace(found, stage=replace(found.stage, named=(Named(ActiveEffect.typical("slope"), {}, 2.0),)))
    assert borne_out.beside_another_ratio(named, change, cast(Any, Extension()), 1.0) is named
