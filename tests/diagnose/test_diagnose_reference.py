"""The command with an earlier campaign: what was so then is no news, what changed since is named."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from blind.protocol import usual
from serpenoid.body import Body
from serpenoid.cli.main import main
from serpenoid.diagnose import reference
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.noise import residuals
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.recordings.told import Told
from serpenoid.diagnose.data.windows.tracks import make_tracks
from serpenoid.diagnose.diagnose import Diagnosis, diagnose
from serpenoid.diagnose.inference.fits.finding import Named, Stage
from serpenoid.diagnose.inference.fits.medium import linearised
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.diagnose.reference import Reference, about, as_taken, in_other_cycles, reference_of
from serpenoid.diagnose.stages.actuation.choose_actuation import beside_a_larger, choose_actuation
from serpenoid.diagnose.stages.actuation.choose_set_points import plays
from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.motion import stand_ins
from serpenoid.diagnose.stages.motion.choose_motion import GUESS
from serpenoid.diagnose.stages.motion.values_of_motion import beside_known
from serpenoid.diagnose.start import baseline
from serpenoid.effects.active import ActiveEffect
from serpenoid.errors import InputError
from serpenoid.measure.logs import TICK
from serpenoid.medium import Medium
from serpenoid.model import Model

TOE = Effect("toe", None, {"angle": 0.05})  # there all the time
INERTIA = ActiveEffect.of("inertia", relaxation_time=0.05)
ZERO = Effect("zero_offset", 6, {"offset": 0.05})


def test_what_changed_since_the_reference_is_named_and_what_was_so_is_not(tmp_path: Path) -> None:
    few = COMBINATIONS[:1]
    write(make(61, [TOE], "then", few), tmp_path / "then")
    write(make(61, [TOE, ZERO], "now", few, chance=(1,)), tmp_path / "now")
    out = tmp_path / "out"
    options = ["--reference", str(tmp_path / "then"), "--out", str(out), "--no-figures", "--quiet"]
    assert main(["diagnose", str(tmp_path / "now"), *options]) == 0
    said = json.loads((out / "diagnosis.json").read_text())
    assert said["verdict"] == "explained"
    (found,) = said["effects"]
    assert (found["name"], found["place"]) == ("zero_offset", 6)
    low, high = found["parameters"]["offset"]["interval"]
    assert low < ZERO.parameters["offset"] < high
    assert said["reference"]["verdict"] == "explained"
    assert [e["name"] for e in said["reference"]["effects"]] == ["toe"]


def test_the_same_recordings_and_another_body_are_no_reference(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(make(61, [], "then", COMBINATIONS[:1]), tmp_path / "then")
    shutil.copytree(tmp_path / "then", tmp_path / "copied")
    shutil.copytree(tmp_path / "then", tmp_path / "longer")
    file = tmp_path / "longer" / "campaign.toml"
    first = float(re.findall(r"edge_lengths = \[([0-9.]+)", file.read_text())[0])
    file.write_text(file.read_text().replace(f"[{first}", f"[{1.2 * first:.4f}"))
    for now, said in {"copied": "byte by byte: nothing can have changed", "longer": "of another body"}.items():
        assert main(["diagnose", str(tmp_path / now), "--reference", str(tmp_path / "then"), "--no-figures"]) == 2
        assert said in capsys.readouterr().err


@pytest.mark.slow
def test_a_camera_that_was_stretched_then_is_taken_out_and_is_no_news(tmp_path: Path) -> None:
    """Nothing is left to be fitted on its stage, and clocks are laid beside it all the same."""
    camera = Effect("camera_stretch", None, {"longer": 0.008, "shear": -0.006})
    for name, day in (("then", (1,)), ("now", ())):
        write(make(62, [camera], name, COMBINATIONS[:1], chance=day), tmp_path / name)
    out = tmp_path / "out"
    options = ["--reference", str(tmp_path / "then"), "--out", str(out), "--no-figures", "--quiet"]
    assert main(["diagnose", str(tmp_path / "now"), *options]) == 0
    said = json.loads((out / "diagnosis.json").read_text())
    assert said["verdict"] == "nothing"
    assert [e["name"] for e in said["reference"]["effects"]] == ["camera_stretch"]
    assert "camera_stretch" in (out / "extended-model.toml").read_text()


@pytest.fixture(scope="module")
def earlier(tmp_path_factory: pytest.TempPathFactory) -> Diagnosis:
    folder = tmp_path_factory.mktemp("earlier")
    write(make(61, [TOE], combinations=COMBINATIONS[:1]), folder)
    file, recordings = read_recordings(folder)
    return diagnose(recordings, Baseline(baseline(None, file, file.body)), lambda text: None)


def first_errors(earlier: Diagnosis) -> tuple[np.ndarray, np.ndarray]:
    """What the first setting's repeats were off by (2, W, 3), and which windows both of them show."""
    model = earlier.extension.model
    motion = about(earlier, model)
    errors = residuals(motion.tracks, linearised(motion, model, model.effects)[1])
    setting = motion.tracks[0].recording.setting
    first = np.array([e for t, e in zip(motion.tracks, errors, strict=True) if t.recording.setting == setting])
    both = np.isfinite(first).all(axis=(0, 2))
    assert both.mean() > 0.5
    return first, both


def test_differences_tell_the_chance_of_both_days_where_nothing_was_played_twice(
    earlier: Diagnosis, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the model left then is no noise of what it leaves now: the habitual error is in both, and is taken out."""
    then, tracks = reference_of(earlier), earlier.motion.selection.motion.tracks
    for said, doubtful in (("trials", True), ("residuals", False)):
        monkeypatch.setattr(reference, "chance_from", lambda _, said=said: said)
        (first, *_) = then.corrected(tracks)
        known = ~np.asarray(first.recurs).any(axis=1) & first.playing
        assert known.mean() > 0.5
        assert bool(np.broadcast_to(first.doubt, first.displacement.shape)[known].all()) == doubtful


def test_the_habitual_error_is_the_mean_over_repeats(earlier: Diagnosis) -> None:
    first, both = first_errors(earlier)
    (known,) = reference_of(earlier).explained[:1]
    habit = known.habits[earlier.motion.selection.motion.tracks[0].recording.setting]
    assert len(first) == 2
    np.testing.assert_allclose(habit.error[both], first.mean(axis=0)[both], atol=1e-12)


def test_a_reference_of_another_body_is_refused(earlier: Diagnosis) -> None:
    lengths = [1.1 * e for e in earlier.model.body.edges_m]
    with pytest.raises(InputError, match="another body"):
        reference_of(earlier).check(Body(vertices=12, edge_lengths=tuple(lengths)))


def test_a_gait_not_played_before_leaves_all_the_habitual_error_in_doubt(earlier: Diagnosis) -> None:
    known = reference_of(earlier)
    track = earlier.motion.selection.motion.tracks[0]
    new = replace(track, recording=replace(track.recording, gait="new"))
    old, fresh = known.corrected([track, new])
    np.testing.assert_array_equal(fresh.offset, track.offset)
    np.testing.assert_allclose(fresh.doubt[fresh.playing], np.broadcast_to(known.usual, (fresh.playing.sum(), 3)))
    told = old.playing & first_errors(earlier)[1]
    assert (old.doubt[told] < known.usual).all()


GRIP = Effect("grip_saturation", None, {"saturation_speed": 0.03})
SLOPE = Effect("slope", None, {"pull_x": 0.008, "pull_y": 0.005})


@pytest.mark.slow  # the search of the earlier campaign, which nothing in the catalogue explains
def test_a_change_is_named_though_the_catalogue_does_not_hold_the_law_of_the_floor(tmp_path: Path) -> None:
    few = COMBINATIONS[:2]
    write(make(62, [], "then", few, base=[GRIP]), tmp_path / "then")
    write(make(62, [SLOPE], "now", few, base=[GRIP], chance=(1,)), tmp_path / "now")
    options = ["--reference", str(tmp_path / "then"), "--without=grip_saturation", "--no-figures", "--quiet"]
    assert main(["diagnose", str(tmp_path / "now"), *options, "--out", str(tmp_path / "out")]) == 0
    said = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert said["reference"]["verdict"] != "explained"
    (named,) = said["effects"]  # marked: of two gaits on another law, a pull at one vertex leaves a little less
    assert named["name"] == "slope"
    pull = [named["parameters"][f"pull_{axis}"]["value"] for axis in "xy"]
    assert np.arctan2(*pull[::-1]) == pytest.approx(np.arctan2(0.005, 0.008), abs=0.05)


def test_what_a_reference_did_not_see_is_filled_by_the_same_phase_of_other_cycles() -> None:
    phase = np.array([0.25, 0.75, 0.25, 0.75, 0.25, 0.75])
    mean = np.array([1.0, 5.0, 1.2, np.nan, 0.8, 5.2])[:, None] * np.ones(3)
    filled, noise = in_other_cycles(mean, np.full((6, 3), 0.1), phase)
    np.testing.assert_allclose(filled[3], 5.1)
    # four values more than two means: sum of squares 0.04 + 0.04 + 0.01 + 0.01 over 3 degrees of freedom
    np.testing.assert_allclose(noise[3], np.sqrt(0.1 / 3 * 1.5))
    np.testing.assert_array_equal(noise[0], 0.1)


def test_one_cycle_fills_nothing() -> None:
    mean = np.array([1.0, np.nan])[:, None] * np.ones(3)
    filled, _ = in_other_cycles(mean, np.full((2, 3), 0.1), np.array([0.25, 0.75]))
    assert np.isnan(filled[1]).all()


LATE = 0.0042  # s
SOFT = 0.05  # s: by how much servos are late, and as much once more for how fast their neighbours turn


@pytest.fixture(scope="module")
def followed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Recording, ...]:
    folder = tmp_path_factory.mktemp("followed")
    write(make(63, [], combinations=COMBINATIONS[:2]), folder)
    return read_recordings(folder)[1]


def _soft(recordings: Sequence[Recording], times: float) -> list[Recording]:
    """Servos that miss rows that run by more than one law holds."""
    rng = np.random.default_rng(8)

    def read(r: Recording) -> Recording:
        r = replace(r, schedule=replace(r.schedule, held=False), told=None, commands=None)
        told = r.schedule.commanded(r.read_at)
        rate = np.gradient(told, r.read_at, axis=0)
        done = told - SOFT * times * (rate + np.roll(rate, 1, axis=1)) + 0.4 * TICK * rng.normal(size=told.shape)
        return replace(r, position=TICK * np.round(done / TICK))

    return [read(r) for r in recordings]


def _changed(recordings: Sequence[Recording], times: float) -> tuple[Reference, Stage]:
    """What is said of servos that have come to miss it so many times as much as in the reference."""
    model, unknown = Model(recordings[0].body, Medium(anisotropy_ratio=0.2)), np.ones(3)
    then = plays(_soft(recordings, 1.0))
    reference = Reference(model, Observation.neutral(model.body), (), unknown, unknown, then, 0.0)
    return reference, choose_actuation(reference.plays(_soft(recordings, times)))


@pytest.mark.slow
def test_a_habit_of_readings_is_in_both_campaigns_and_no_noise_of_their_difference(
    followed: tuple[Recording, ...],
) -> None:
    reference, stage = _changed(followed, 2.1)  # the change is 1.1 times the habit: visible, and no sum of two of them
    (named,) = stage.named  # the nearest law of all servos: none holds
    assert named.effect.name in ("servo_lag", "servo_inertia")
    now = reference.plays(_soft(followed, 1.0))
    alike = now.left(now.realised([]))
    assert np.sqrt((alike**2).mean()) < 2 * np.sqrt((now.noise**2).mean())
    assert (now.noise < np.asarray(now.unsure) / 5).all()


@pytest.mark.slow
def test_less_than_the_habit_of_readings_says_nothing_of_servos(followed: tuple[Recording, ...]) -> None:
    _, stage = _changed(followed, 1.8)  # 0.8 times: the floor alone may do as much
    assert not stage.named
    assert stage.settled


LAG, LAGS = 0.12, 1  # s; a joint, from 0


def _lagging(r: Recording) -> Recording:
    """One servo follows what it used to do by a first-order lag."""
    done, steps = r.position.copy(), np.diff(r.read_at)
    for n, step in enumerate(steps):
        toward = 1 - np.exp(-step / LAG)
        done[n + 1, LAGS] = done[n, LAGS] + toward * (r.position[n, LAGS] - done[n, LAGS])
    return replace(r, position=np.round(done / TICK) * TICK)


@pytest.mark.slow
def test_an_interval_holds_what_a_change_changes_of_the_habit_of_readings(followed: tuple[Recording, ...]) -> None:
    """The joint lags behind what it did, not behind its command, as the law has it."""
    model, unknown = Model(followed[0].body, Medium(anisotropy_ratio=0.2)), np.ones(3)
    then = plays(_soft(followed, 1.0))
    reference = Reference(model, Observation.neutral(model.body), (), unknown, unknown, then, 0.0)
    stage = choose_actuation(reference.plays([_lagging(r) for r in _soft(followed, 1.0)]))
    (named,) = stage.named
    assert (named.effect.name, named.effect.place) == ("lagging_joint", LAGS + 1)
    low, high = named.intervals["lag"]
    assert low is not None
    assert high is not None
    assert low < LAG < high
    assert high - low < LAG


@pytest.mark.parametrize(
    "between", [pytest.param(0.0, marks=pytest.mark.slow), 0.5]
)  # of the way from one of the earlier readings to the next
def test_noise_of_the_earlier_readings_is_no_habit_and_counts_once(
    followed: tuple[Recording, ...], between: float
) -> None:
    """Labels are good to 2.1 ms: of 4.2 ms they leave little more than noise of a difference."""
    rng = np.random.default_rng(4)

    def read_again(r: Recording, late: float, between: float = 0.0) -> Recording:
        r = replace(r, log_time=r.log_time + between * np.median(np.diff(r.log_time)))
        done = r.schedule.commanded(r.read_at - late) + 0.4 * TICK * rng.normal(size=r.position.shape)
        return replace(r, position=np.round(done / TICK) * TICK)

    model, unknown = Model(followed[0].body, Medium(anisotropy_ratio=0.2)), np.ones(3)
    then = plays([read_again(r, 0.0) for r in followed])
    reference = Reference(model, Observation.neutral(model.body), (), unknown, unknown, then, 0.0)
    alike = reference.plays([read_again(r, 0.0, between) for r in followed])
    assert (np.asarray(alike.unsure) < alike.noise / 2).all()
    left = alike.left(alike.realised([]))
    assert np.sqrt((left**2).mean()) == pytest.approx(np.sqrt((alike.noise**2).mean()), rel=0.04)
    stage = choose_actuation(reference.plays([read_again(r, LATE, between) for r in followed]))
    assert [n.effect.name for n in stage.named] == ["servo_delay"]
    assert stage.settled


@pytest.mark.parametrize(("inadequate", "marked"), [(False, True), (True, False)])
def test_names_of_the_floor_are_marked_where_what_repeats_is_news(
    inadequate: bool, marked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A reference that missed nothing makes no excuse for what is left; of one that did, the change is what takes away
    most. A pull at one vertex beside a healthy reference was named `slope`, without a mark."""
    monkeypatch.setattr(stand_ins, "untold", lambda *_: None)
    monkeypatch.setattr(stand_ins, "residuals", lambda *_: [])
    slope = ActiveEffect.typical("slope", None)
    fit = SimpleNamespace(effects=[slope], chi2=1.0, predictions=())
    motion = SimpleNamespace(ratio=0.2, tracks=())
    found = SimpleNamespace(motion=motion, best=fit, bases=[SimpleNamespace(chi2=9.0)], settled=fit)
    (named,) = stand_ins.with_stand_ins(cast(Selection, found), [Named(slope, {}, 5.0)], inadequate)
    assert named.stand_in == marked


def test_rows_and_beginnings_are_as_in_a_reference_where_a_log_does_not_say(tmp_path: Path) -> None:
    """Rows that are held and servos that lag look like rows that run and begin later."""
    lag, protocol = 0.05, replace(usual(63, COMBINATIONS[:1]), held=True)
    write(make(63, [Effect("servo_lag", None, {"lag": lag})], protocol=protocol), tmp_path)
    then = read_recordings(tmp_path)[1]
    model, unknown = Model(then[0].body, Medium(anisotropy_ratio=0.2)), np.ones(3)
    servos = replace(plays(then), known=(ActiveEffect.of("servo_lag", lag=lag),))
    reference = Reference(model, Observation.neutral(model.body), (), unknown, unknown, servos, 0.0)
    assert reference.rows_held([]) is True
    assert reference.rows_held(then) is True  # whose commands say the same
    other = [replace(r, told=replace(cast(Told, r.told), held=False)) for r in then]
    assert reference.rows_held(other) is None  # played by another player, as its commands say
    run = tuple(r.taken(held=False, goals=False) for r in then)
    smooth = replace(reference, servos=replace(servos, recordings=run))
    assert smooth.rows_held(then) is False  # what readings followed best then, whatever they follow best now
    assert reference.rows_said
    read = tuple(replace(r, told=None, commands=None) for r in servos.recordings)
    silent = replace(reference, servos=replace(servos, recordings=read))  # rows as they were taken, if nobody said it
    assert silent.rows_held([]) is True
    assert not silent.rows_said
    quarter = 0.25 * then[0].schedule.cycle_duration_s
    unsaid = [replace(r, told=None, commands=None, t0_spread=quarter).later(0.06) for r in then]
    assert reference.plays(unsaid).held
    for r, laid in zip(then, reference.begun(unsaid), strict=True):
        assert laid.time[0] == pytest.approx(r.time[0], abs=1e-3)
        assert laid.log_time[0] == pytest.approx(r.log_time[0], abs=1e-3)


@pytest.mark.parametrize(
    ("before", "least", "most"),
    [
        (None, 0.2, 0.4),  # a guess: of 0.1 none may have been there
        (Named(ActiveEffect.of("load", 3, share=0.1), {"share": (0.07, 0.12)}, 5.0), 0.27, 0.42),
        (Named(ActiveEffect.of("load", 3, share=0.1), {"share": (0.07, 0.12)}, 5.0, stand_in=True), 0.2, 0.42),
    ],
)
def test_intervals_hold_how_far_what_was_known_of_the_same_effect_may_be_off(
    before: Named | None, least: float, most: float
) -> None:
    body = Body(vertices=12)
    load, unknown = ActiveEffect.of("load", 3, share=0.1), np.ones(3)
    model = Model(body, Medium(anisotropy_ratio=0.2), (load,))
    servos, named = cast(Plays, None), () if before is None else (before,)
    reference = Reference(model, Observation.neutral(body), (), unknown, unknown, servos, 1e-3, named=named)
    now = Named(ActiveEffect.of("load", 3, share=0.35), {"share": (0.3, 0.4)}, 5.0)
    assert beside_known(now, reference.doubt_of(now.effect)).intervals["share"] == pytest.approx((least, most))
    other = Named(ActiveEffect.of("load", 4, share=0.35), {"share": (0.3, 0.4)}, 5.0)
    assert beside_known(other, reference.doubt_of(other.effect)) == other


@pytest.mark.parametrize("held", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_rows_of_a_reference_are_as_its_own_answer_took_them(held: bool, tmp_path: Path) -> None:
    lagging, protocol = Effect("servo_lag", None, {"lag": 0.05}), replace(usual(63, COMBINATIONS[:1]), held=True)
    write(make(63, [lagging], protocol=protocol), tmp_path)
    read = [replace(r, told=None, commands=None) for r in read_recordings(tmp_path)[1]]
    assert plays(read).held
    taken = [replace(r, schedule=replace(r.schedule, held=held)) for r in read]
    assert as_taken(taken).held == held


def test_what_the_mesh_misses_is_that_of_the_model_whose_error_is_a_habit(followed: tuple[Recording, ...]) -> None:
    model, labels = Model(followed[0].body, Medium(anisotropy_ratio=0.2)), tuple(range(len(followed)))
    other, seen = replace(model, effects=(INERTIA,)), Observation.neutral(model.body)
    motion = Motion(make_tracks(followed, seen, other), GUESS, labels)
    d: Any = SimpleNamespace(motion=SimpleNamespace(selection=SimpleNamespace(motion=motion)), seen=seen)
    for track, own in zip(about(d, model).tracks, make_tracks(followed, seen, model), strict=True):
        np.testing.assert_array_equal(track.offset, own.offset)
    far = np.concatenate([a.offset - b.offset for a, b in zip(about(d, model).tracks, motion.tracks, strict=True)])
    assert np.abs(far[:, :2]).max() > 1e-4  # what was subtracted from one campaign and not from the other


@pytest.mark.parametrize(
    ("before", "after", "remains"),
    [(168.0, 80.0, 0.475), (26.0, 5.0, 0.0), (4.0, 3.0, 0.0), (4.0, 4.5, 1.0)],  # noise alone, in the last two
)
def test_what_remains_of_a_path_is_told_beyond_noise(before: float, after: float, remains: float) -> None:
    assert stand_ins.left_of(before, after, 5.0) == pytest.approx(remains, abs=1e-3)


@pytest.mark.parametrize(("without", "marked"), [(12.0, True), (80.0, False)])
def test_a_name_beside_which_a_third_of_its_own_trace_remains_is_marked(
    without: float, marked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All names take the path error from 90 to 9.5 noise levels; without the load it would be 12."""
    load, toe = ActiveEffect.of("load", 3, share=0.02), ActiveEffect.of("toe", angle=0.1)
    bases = (SimpleNamespace(predictions=without), SimpleNamespace(predictions=85.0))
    found: Any = SimpleNamespace(
        motion=SimpleNamespace(ratio=0.2), best=SimpleNamespace(effects=(load, toe)), bases=bases, noise_level_m=1.0
    )
    monkeypatch.setattr(stand_ins, "path_error", lambda motion, predictions: predictions)
    names = stand_ins.mending(found, [Named(load, {}, 4.0), Named(toe, {}, 70.0)], 90.0, 9.5)
    assert [n.stand_in for n in names] == [marked, False]


def test_a_law_of_all_servos_beside_a_larger_change_may_be_what_loads_make_of_a_law_that_is_wrong() -> None:
    loss = Named(ActiveEffect.of("gain_loss", 2, loss=0.25), {"loss": (0.2, 0.3)}, 4.0)
    lag = Named(ActiveEffect.of("servo_lag", lag=0.015), {"lag": (0.008, 0.023)}, 1.4)
    known, wrong = (cast(Plays, SimpleNamespace(noise=np.full(6, 1e-3), unsure=u)) for u in (0.0, np.full(6, 0.06)))
    assert [n.stand_in for n in beside_a_larger(wrong, [loss, lag])] == [False, True]
    assert [n.stand_in for n in beside_a_larger(wrong, [lag])] == [False]  # it is the change
    assert [n.stand_in for n in beside_a_larger(known, [loss, lag])] == [False, False]
    other = Named(ActiveEffect.of("gain_loss", 5, loss=0.1), {"loss": (0.05, 0.15)}, 2.0)  # at a joint of its own
    assert [n.stand_in for n in beside_a_larger(wrong, [loss, other])] == [False, False]
