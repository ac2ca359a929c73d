"""Recordings of other kinds than the usual: slow logs and cameras, none, hidden markers, rows that jump."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from blind.cameras import Instruments
from blind.campaign import Campaign, make
from blind.catalogue import Effect
from blind.folder import write
from blind.protocol import COMBINATIONS, Protocol, usual
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.noise.noise import window_noise
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.shapes.course import Course
from serpenoid.diagnose.data.shapes.shape_in_time import Source, fitted, worth
from serpenoid.diagnose.data.shapes.shapes_from_points import angles_read, angles_shown
from serpenoid.diagnose.data.windows.tracks import make_tracks
from serpenoid.diagnose.stages.actuation.choose_actuation import choose_actuation
from serpenoid.diagnose.stages.actuation.choose_set_points import plays
from serpenoid.diagnose.stages.actuation.expected import carried
from serpenoid.diagnose.stages.observation.choose_observation import choose_observation
from serpenoid.diagnose.start import baseline
from serpenoid.effects.active import ActiveEffect
from serpenoid.errors import InputError
from serpenoid.measure.logs import TICK
from serpenoid.measure.remark import Remark

SEED = 21


def protocol(**instruments: object) -> Protocol:
    """One gait of the usual robot, played twice, seen by other instruments."""
    return replace(usual(SEED, COMBINATIONS[1:2]), instruments=Instruments(**instruments))  # type: ignore[arg-type]


def recorded(campaign: Campaign, folder: Path) -> tuple[Recording, ...]:
    write(campaign, folder)
    return read_recordings(folder)[1]


def angle_error(campaign: Campaign, recordings: tuple[Recording, ...]) -> float:
    """RMS [rad] between the shapes of a diagnosis and the true ones, while all markers are seen."""
    squares = []
    for trial, r in zip(campaign.trials, recordings, strict=True):
        inside = (r.time > 0) & (r.time < r.end) & np.isfinite(r.markers[..., 0]).all(axis=1)
        true = [np.interp(r.time[inside], trial.drive.time, column) for column in trial.drive.phi.T]
        squares.append(((r.angles[inside] - np.stack(true, axis=1)) ** 2).mean())
    return float(np.sqrt(np.mean(squares)))


def test_a_spline_keeps_a_wave_and_the_corner_where_it_begins() -> None:
    time = np.arange(-1.0, 2.0, 1 / 60)
    wave = np.where(time > 0, np.sin(2 * np.pi * time / 1.5), 0.0)
    shape = fitted([Source.of(time, wave[:, None], np.array([1e-3]))], np.array([0.0]), 0.05)
    fine = np.linspace(-0.9, 1.9, 500)
    true = np.where(fine > 0, np.sin(2 * np.pi * fine / 1.5), 0.0)
    assert np.abs(shape.at(fine)[:, 0] - true).max() < 1e-3  # the rate jumps by 4 rad/s at 0


def test_readings_of_a_joint_at_rest_have_one_rounding_and_do_not_bend_what_comes_before() -> None:
    """Where the joint rests between two ticks, half a second of equal readings is no proof that it rests on one."""
    time = np.arange(0.0, 4.0, 0.01)
    true = 0.4 * np.sin(2 * np.pi * np.minimum(time, 2.0) / 2.0) + 0.4 * TICK
    read = np.round(true / TICK)[:, None] * TICK
    carrier = Course(time, (true - 0.4 * TICK)[:, None])  # what it was told; it is off by less than a tick

    def off(tick: float) -> float:
        source = Source.of(time, read, np.array([TICK / 2]), tick)
        shape = fitted([source], np.array([2.0]), 0.078, True, carrier)
        jump = shape.at(np.array([1.5, 2.5])) - np.array([[np.interp(t, time, true)] for t in (1.5, 2.5)])
        return float(abs(jump[1, 0] - jump[0, 0]))

    assert off(TICK) < 0.6 * off(0.0)


def test_readings_that_noise_stirs_are_worth_all_of_them() -> None:
    rng = np.random.default_rng(1)
    stirred = np.round(rng.normal(0, 1.0, (200, 6)))
    assert worth(stirred * TICK, TICK).sum() > 180
    assert worth(np.zeros((200, 6)), TICK).sum() == pytest.approx(1.0)


def test_markers_fill_in_where_the_log_is_slow(tmp_path: Path) -> None:
    """A log at 10 Hz alone would miss corners of a set-point by tens of milliradians."""
    slow = make(SEED, 0, protocol=protocol(log_hertz=10.0))
    error = angle_error(slow, recorded(slow, tmp_path))
    assert error < 3e-3


def test_without_a_log_shapes_are_what_the_markers_show(tmp_path: Path) -> None:
    blind = make(SEED, 0, protocol=protocol(log_hertz=0.0))
    recordings = recorded(blind, tmp_path)
    assert not any(r.by_servos for r in recordings)
    assert angle_error(blind, recordings) < 5e-3  # markers of 0.2 mm show a joint to 6 mrad in one frame


def test_without_a_log_what_a_hidden_vertex_leaves_open_is_no_reading(tmp_path: Path) -> None:
    """Of a joint that is nearly straight there are two mirror positions, and noise chooses. Hidden it is bent as it
    was commanded."""
    blind = make(SEED, 0, protocol=protocol(log_hertz=0.0, marker_noise=4e-4))
    seen = recorded(blind, tmp_path)
    worst = 0.0
    for r in carried(seen, plays(seen), []):
        markers, angles, inside = r.markers.copy(), r.angles, (r.time > 0.5) & (r.time < r.end - 0.5)
        straight = np.where(inside[:, None], np.abs(angles), np.inf)
        for joint in (2, 5):
            hidden = np.abs(r.time - r.time[straight[:, joint].argmin()]) < 0.2
            markers[hidden, joint + 1] = np.nan
        read = angles_read(r.body, markers, *angles_shown(r.body, markers))
        found = replace(r, markers=markers, position=read).angles
        worst = max(worst, float(np.abs(found - angles).max()))
    assert worst < 0.03, worst


@pytest.mark.slow
def test_without_a_log_a_hidden_vertex_says_nothing_of_the_servos(tmp_path: Path) -> None:
    blind = make(SEED, 0, protocol=protocol(log_hertz=0.0, marker_noise=4e-4))

    def hidden(r: Recording) -> Recording:
        markers, times = r.markers.copy(), np.floor(r.time / 0.3).astype(int)
        for vertex in (3, 6):
            markers[times % 5 == vertex % 5, vertex] = np.nan
        read = angles_read(r.body, markers, *angles_shown(r.body, markers))
        return replace(r, markers=markers, position=read)

    seen = recorded(blind, tmp_path)
    found = plays([hidden(r) for r in seen])
    assert not found.read.all()
    stage = choose_actuation(found)
    assert not stage.named
    assert stage.settled, stage.words
    np.testing.assert_allclose(found.noise, plays(seen).noise, rtol=0.1)


@pytest.mark.slow
def test_without_a_log_a_joint_that_is_never_read_has_no_name_and_is_as_it_was_told(tmp_path: Path) -> None:
    blind = make(SEED, 0, protocol=protocol(log_hertz=0.0, marker_noise=4e-4))

    def unread(r: Recording) -> Recording:
        return replace(r, position=np.where(np.arange(r.body.joint_count) == 4, np.nan, r.position))

    recordings = [unread(r) for r in recorded(blind, tmp_path)]
    found = plays(recordings)
    stage = choose_actuation(found)
    assert not stage.named
    assert stage.settled, stage.words
    assert angle_error(blind, carried(recordings, found, [])) < 1e-2


def test_without_labels_a_joint_that_lags_does_not_make_trials_begin_late(tmp_path: Path) -> None:
    """A joint of ten that lags by 0.2 s makes trials seem to begin 20 ms late: motion before that would be lost."""
    lagging = Effect("lagging_joint", 4, {"lag": 0.2})
    late = make(SEED, [lagging], protocol=protocol(log_hertz=0.0))
    recordings = recorded(late, tmp_path)
    found = plays(recordings)
    effect = ActiveEffect.of(lagging.name, lagging.place, **lagging.parameters)
    begun = carried(recordings, found, [effect])
    assert angle_error(late, begun) < 2e-3
    times = zip(late.trials, recordings, begun, strict=True)
    assert all(abs(r.time[0] - t.film.time[0]) < 2e-3 < abs(before.time[0] - t.film.time[0]) for t, before, r in times)


def test_without_a_log_joints_that_no_frame_shows_are_named_as_assumed(tmp_path: Path) -> None:
    recordings = recorded(make(SEED, 0, protocol=protocol(log_hertz=0.0, unseen=(5,))), tmp_path)
    for r in recordings:
        assert any("no frame shows joints 4, 5, 6" in one.words and "assumed" in one.words for one in r.remarks)


@pytest.mark.parametrize(
    "unseen", [*(pytest.param(k, marks=pytest.mark.slow) for k in ((5,), (2, 5, 8))), (2, 4, 6, 8, 10)]
)
def test_without_a_log_the_motion_begins_where_the_polygon_of_those_seen_says(
    unseen: tuple[int, ...], tmp_path: Path
) -> None:
    """A hidden vertex between two joints has two mirror positions, and angles of the wrong one follow no table."""
    some = make(SEED, 0, protocol=protocol(log_hertz=0.0, unseen=unseen))
    for trial, r in zip(some.trials, recorded(some, tmp_path), strict=True):
        assert r.time[0] == pytest.approx(trial.film.time[0], abs=2e-3)


@pytest.mark.parametrize("vertex", [pytest.param(0, marks=pytest.mark.slow), 5])
def test_a_marker_that_is_never_seen_hides_nothing_else(vertex: int, tmp_path: Path) -> None:
    one = make(SEED, 0, protocol=protocol(unseen=(vertex,)))
    recordings = recorded(one, tmp_path)
    for trial, r in zip(one.trials, recordings, strict=True):
        # camera clocks count from the first frame; t0 is found to a fraction of a frame
        assert r.time[0] == pytest.approx(trial.film.time[0], abs=2e-3)


def test_a_log_of_another_motion_is_refused_with_its_remedy(tmp_path: Path) -> None:
    write(make(SEED, 0, protocol=protocol()), tmp_path)
    log = tmp_path / "gait02-a-1" / "servo.csv"
    first, *lines = log.read_text().splitlines()
    rows = [line.split(",") for line in lines]
    positions = [k for k, name in enumerate(first.split(",")) if name.startswith("position_")]
    for row in rows:
        for k in positions:
            row[k] = f"{0.4 * np.sin(2.3 * float(row[0]) * (1 + 0.4 * np.cos(k))):.5f}"
    log.write_text("\n".join([first, *(",".join(row) for row in rows)]) + "\n")
    with pytest.raises(InputError, match=r"gait02-a-1.*follow neither.*another trial"):
        read_recordings(tmp_path)
    shuffled = np.random.default_rng(0).permutation(lines)
    mixed = [f"{a.split(',', 1)[0]},{b.split(',', 1)[1]}" for a, b in zip(lines, shuffled, strict=True)]
    log.write_text("\n".join([first, *mixed]) + "\n")
    with pytest.raises(InputError, match=r"gait02-a-1.*no motion beyond their noise.*rows in disorder"):
        read_recordings(tmp_path)


@pytest.mark.slow
def test_cycles_that_are_not_in_the_recording_are_said_and_cost_nothing(tmp_path: Path) -> None:
    campaign = make(SEED, 0, protocol=usual(SEED, COMBINATIONS[1:2]))
    (whole, *_) = recorded(campaign, tmp_path)
    assert whole.remarks == ()
    file = tmp_path / "campaign.toml"
    file.write_text(re.sub("^cycles = .*", "cycles = 100000", file.read_text(), flags=re.MULTILINE))
    said = read_recordings(tmp_path)[1][0].remarks
    assert said == (Remark("2 of 100000 promised cycles were played, say the log's labels"),)
    for log in tmp_path.glob("*/servo.csv"):  # a log that does not say it
        log.write_text(log.read_text().replace(",phase,", ",said,", 1))
    said = (Remark("2 of 100000 promised cycles were played, say the film and what servos read"),)
    assert read_recordings(tmp_path)[1][0].remarks[-1:] == said  # unless they end amid motion
    ends = f"to_s = {1.5 * whole.schedule.period_s - whole.time[0]}\nmotion ="
    file.write_text(re.sub("^motion =", ends, file.read_text(), flags=re.MULTILINE))
    recordings = read_recordings(tmp_path)[1]
    r = recordings[0]
    assert r.promised_s == 100_000 * r.schedule.period_s
    assert r.schedule.cycles <= 1 + np.ceil(max(r.time[-1], r.log_time[-1]) / r.schedule.period_s)
    missing = 100_000 - r.schedule.cycles
    said = f"of 100000 promised cycles, {missing} would begin after the recording: left out"
    assert Remark(said) in r.remarks
    assert sum(len(mesh) for mesh in plays(recordings).meshes) < 10**6  # of 10**8


@pytest.mark.parametrize("held", [True, False])
def test_rows_that_jump_are_told_from_rows_that_are_run_through(held: bool, tmp_path: Path) -> None:
    lag = 0.03
    campaign = make(SEED, [Effect("servo_lag", None, {"lag": lag})], protocol=replace(protocol(), held=held))
    data = plays(recorded(campaign, tmp_path))
    assert data.held == held
    (named,) = choose_actuation(data).named
    # half a row is 25 to 70 ms here; a jump of the generator takes one fine step, 2 ms
    assert named.effect.parameters["lag"] == pytest.approx(lag, abs=2e-3)


def test_one_rate_of_the_clock_serves_all_trials(tmp_path: Path) -> None:
    rate = 4e-3
    noisy = make(
        SEED,
        [Effect("clock_offset", None, {"rate": rate})],
        protocol=protocol(marker_noise=2e-3, frames_per_second=30.0),
    )
    rates = {r.clock.rate for r in recorded(noisy, tmp_path)}
    assert len(rates) == 1
    assert rates.pop() == pytest.approx(rate, abs=1e-3)


def test_a_clock_that_runs_otherwise_in_one_trial_is_that_trials(tmp_path: Path) -> None:
    """As of a camera that was started anew, or of another one."""
    rate, both = -3e-3, protocol()
    healthy, clocked = (make(SEED, some, protocol=both) for some in (0, [Effect("clock_offset", None, {"rate": rate})]))
    write(healthy, tmp_path / "healthy")
    write(clocked, tmp_path / "clocked")
    name = healthy.trials[-1].name
    shutil.copytree(tmp_path / "clocked" / name, tmp_path / "healthy" / name, dirs_exist_ok=True)
    recordings = read_recordings(tmp_path / "healthy")[1]
    assert [r.clock.rate for r in recordings] == pytest.approx([rate * (r.name == name) for r in recordings], abs=1e-4)
    stage, _ = choose_observation(recordings, Observation.neutral(recordings[0].body))
    assert not stage.named
    assert stage.divided is not None
    assert stage.divided.changed == (name,)
    assert stage.divided.any_gait
    assert stage.words[0].startswith(f"clock_offset is another in `{name}`: rate -0.003")


@pytest.mark.parametrize(
    "tools", [pytest.param({"frames_per_second": 25.0}, marks=pytest.mark.slow), {"marker_noise": 1e-3}]
)
def test_windows_are_usable_and_no_quieter_than_their_markers(tools: dict[str, float], tmp_path: Path) -> None:
    campaign = make(SEED, 0, protocol=protocol(**tools))
    write(campaign, tmp_path)
    file, recordings = read_recordings(tmp_path)
    tracks = make_tracks(recordings, Observation.neutral(file.body), baseline(None, file, file.body))
    assert np.mean([t.usable.mean() for t in tracks]) > 0.7
    noise, differences = window_noise(tracks, [t.displacement for t in tracks])
    assert len(differences)
    for t in tracks:
        assert (noise.chance(t) >= np.asarray(t.least)).all()
        # a centroid of 12 markers averaged over 90 ms, at both ends
        frames = 0.09 * campaign.protocol.instruments.frames_per_second
        expected = campaign.protocol.instruments.marker_noise * np.sqrt(2 / 12 / max(frames, 1.0))
        assert np.median(np.asarray(t.least)[:, 0]) == pytest.approx(expected, rel=0.4)


def test_boundaries_at_which_no_marker_is_seen_add_no_noise(tmp_path: Path) -> None:
    campaign = make(SEED, 0, protocol=protocol(marker_noise=1e-3))
    write(campaign, tmp_path)
    file, recordings = read_recordings(tmp_path)

    def noise(recordings: tuple[Recording, ...]) -> np.ndarray:
        tracks = make_tracks(recordings, Observation.neutral(file.body), baseline(None, file, file.body))
        return window_noise(tracks, [t.displacement for t in tracks])[0].playing

    def late(r: Recording) -> Recording:
        """A film that begins in the middle of a trial."""
        kept = r.time > r.end / 2
        return replace(r, time=r.time[kept], markers=r.markers[kept])

    assert noise(tuple(map(late, recordings))) == pytest.approx(noise(recordings), rel=0.3)


@pytest.mark.slow  # as of a hundred thousand cycles: above
def test_a_cycle_that_the_recording_does_not_show_is_said(tmp_path: Path) -> None:
    write(make(SEED, 0, protocol=protocol()), tmp_path)
    file = tmp_path / "campaign.toml"
    file.write_text(re.sub("^cycles = 2", "cycles = 3", file.read_text(), flags=re.MULTILINE))
    for log in tmp_path.glob("*/servo.csv"):  # nothing labels cycles
        log.write_text(log.read_text().replace(",phase,", ",said,", 1))
    for r in read_recordings(tmp_path)[1]:
        assert Remark("2 of 3 promised cycles were played, say the film and what servos read") in r.remarks
