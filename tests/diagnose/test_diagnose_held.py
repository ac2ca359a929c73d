"""Rows that are held until the next is due: servos jump and rest, and windows of motion follow every jump."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from blind.protocol import usual, with_joints
from blind.schedule import lagged
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.shapes.course import Course
from serpenoid.diagnose.data.shapes.geometry import shapes
from serpenoid.diagnose.data.windows.meshes import COARSER, mesh_of
from serpenoid.diagnose.data.windows.tracks import _at_frames, make_tracks
from serpenoid.diagnose.data.windows.windows import predicted_path, predictions
from serpenoid.diagnose.stages.actuation.actuation_together import fit_together
from serpenoid.diagnose.stages.actuation.choose_actuation import choose_actuation
from serpenoid.diagnose.stages.actuation.choose_set_points import plays
from serpenoid.diagnose.stages.actuation.expected import carried
from serpenoid.diagnose.stages.whole import from_command
from serpenoid.effects.active import ActiveEffect
from serpenoid.group import relative
from serpenoid.measure.logs import TICK
from serpenoid.medium import Medium
from serpenoid.model import Model

SEED, SETTINGS, JOINTS, LAG = 71, 1, 6, 0.02  # s
LATE, OPEN = 0.008, 0.010  # s: a trial's beginning is off, and may be
READ_EVERY = 0.02  # s
FINE = 5e-4  # s
SELDOM, QUICK = 0.025, 2.0  # s from reading to reading, of the fastest row: a servo's limit


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> tuple[Recording, ...]:
    folder = tmp_path_factory.mktemp("held")
    hidden = Effect("servo_lag", None, {"lag": LAG})
    protocol = with_joints(usual(SEED, COMBINATIONS[:SETTINGS]), JOINTS)
    write(make(SEED, [hidden], protocol=replace(protocol, held=True)), folder)
    return read_recordings(folder)[1]


def _begun_late(r: Recording) -> Recording:
    """A log that is read seldom, and says a trial's beginning as badly."""
    apart = float(np.median(np.diff(r.log_time)))
    some = slice(None, None, max(1, round(READ_EVERY / apart)))
    return replace(
        r, time=r.time + LATE, log_time=r.log_time[some] + LATE, position=r.position[some],
        commands=None, t0_spread=OPEN,
    )  # fmt: skip


def _carried(recordings: Sequence[Recording]) -> tuple[tuple[Recording, ...], float]:
    """What servos are expected to do, and the lag that is named."""
    data = plays(recordings)
    assert data.held
    (named,) = choose_actuation(data).named
    return carried(recordings, data, [named.effect]), named.effect.parameters["lag"]


@pytest.fixture(scope="module")
def followed(recordings: tuple[Recording, ...]) -> tuple[Recording, ...]:
    return _carried(recordings)[0]


@pytest.mark.slow
def test_where_rows_jump_a_trial_begins_where_readings_meet_what_servos_do(
    recordings: tuple[Recording, ...], followed: tuple[Recording, ...]
) -> None:
    """A log says of a jump only that it was between two readings: as long as this lag."""
    found, lag = _carried([_begun_late(r) for r in recordings])
    assert lag == pytest.approx(LAG, abs=0.02 * LAG)
    begun, true = ([r.log_time[0] for r in some] for some in (found, followed))
    np.testing.assert_allclose(begun, true, atol=LATE / 10)


@pytest.mark.parametrize("lag", [LAG, LAG / 4], ids=["jumps", "rests for long"])
def test_the_path_that_guides_averages_rests_after_every_jump(followed: tuple[Recording, ...], lag: float) -> None:
    """A cubic in time through the few steps of a quick jump swings on, by 17 % of it, while the body rests."""
    r = followed[0]
    times = np.linspace(0, r.promised_s, 40000)
    late = lagged(times, r.schedule.commanded(times), np.full(len(times) - 1, lag))
    r = replace(r, carrier=Course(times, late), log_time=times, position=late)
    mesh = mesh_of(r)
    model = Model(r.body, Medium(anisotropy_ratio=0.2))
    path = predicted_path(model, shapes(r.body, r.angles_at(mesh.time)), mesh.time, np.zeros(3))
    times = np.unique(np.concatenate([mesh.time, np.linspace(0, r.end, 20 * len(mesh.time))]))
    exact = predicted_path(model, shapes(r.body, r.angles_at(times)), times, np.zeros(3))
    guided = _at_frames(replace(r, time=times), mesh, path)
    jump = np.abs(np.diff(path[mesh.breaks], axis=0))[:, :2].max()
    off = np.abs(guided - exact)[:, :2].max() / jump
    assert off < (0.03 if lag == LAG else 0.08)


def test_steps_follow_every_jump_and_windows_stay_where_they_are(followed: tuple[Recording, ...]) -> None:
    for r in followed:
        mesh, even = mesh_of(r), mesh_of(replace(r, schedule=replace(r.schedule, held=False)))
        np.testing.assert_allclose(mesh.time[mesh.bounds], even.time[even.bounds], atol=1e-8)
        due = np.arange(len(r.schedule.table)) / len(r.schedule.table) * r.schedule.cycle_duration_s
        assert np.abs(mesh.time[:, None] - due).min(axis=0).max() < 1e-8
        assert not (mesh.bounds % COARSER).any()
        assert not (mesh.breaks % COARSER).any()
        assert (np.diff(mesh.time) > 0).all()


def test_windows_of_a_body_that_jumps_are_those_of_steps_far_shorter_than_a_jump(
    followed: tuple[Recording, ...],
) -> None:
    model = Model(followed[0].body, Medium(anisotropy_ratio=0.2))
    tracks = make_tracks(followed, Observation.neutral(model.body), model)
    for track, r, made in zip(tracks, followed, predictions(model, tracks), strict=True):
        ends = track.time[track.boundaries]
        time = np.unique(np.concatenate([np.arange(0.0, ends[-1], FINE), ends]))
        path = predicted_path(model, shapes(r.body, r.angles_at(time)), time, track.poses[0])
        true = path[np.searchsorted(time, ends)]
        np.testing.assert_allclose(made.displacement, relative(true[:-1], true[1:]), atol=5e-6)  # a twentieth of noise


def test_a_simulation_from_commands_jumps_as_the_servos_do(
    recordings: tuple[Recording, ...], followed: tuple[Recording, ...]
) -> None:
    """Joints that run from row to row in a step would be late by half of it: 0.5 mm and more of a window."""
    lag = ActiveEffect.of("servo_lag", lag=LAG)
    model = Model(followed[0].body, Medium(anisotropy_ratio=0.2), (lag,))
    tracks = make_tracks(followed, Observation.neutral(model.body), model)
    for track, r, made in zip(tracks, followed, predictions(model, tracks), strict=True):
        told = from_command(model, track, r.schedule)
        np.testing.assert_allclose(told.displacement, made.displacement, atol=1e-4)  # readings' noise


def _limited(r: Recording, seed: int) -> Recording:
    """Servos that lag and turn no faster than a limit, which no one law holds, in a slow log that says nothing of when
    rows were due."""
    fine = np.arange(0, r.schedule.whole_s, FINE)
    wanted = lagged(fine, replace(r.schedule, held=True).commanded(fine), np.full(len(fine) - 1, LAG))
    quickest = QUICK * np.abs(np.diff(r.schedule.table, axis=0)).max() / r.schedule.row_s
    read = wanted.copy()
    for k in range(1, len(fine)):
        read[k] = read[k - 1] + np.clip(wanted[k] - read[k - 1], -quickest * FINE, quickest * FINE)
    time = np.arange(0, fine[-1], SELDOM)
    seen = np.stack([np.interp(time, fine, joint) for joint in read.T], axis=1)
    seen = np.round((seen + np.random.default_rng(seed).normal(0, TICK, seen.shape)) / TICK) * TICK
    schedule, open_s = replace(r.schedule, held=False), r.schedule.cycle_duration_s / 4
    return replace(r, schedule=schedule, log_time=time, position=seen, commands=None, t0_spread=open_s, told=None)


def test_rows_that_are_held_are_told_though_no_law_of_the_catalogue_is_the_servos(
    recordings: tuple[Recording, ...],
) -> None:
    """Rows that run are off by less than readings scatter about a smooth course, which rows that jump are not."""
    assert plays([_limited(r, n) for n, r in enumerate(recordings)]).held


def test_effects_of_several_joints_are_fitted_together_where_nothing_says_when_trials_began(
    recordings: tuple[Recording, ...],
) -> None:
    """Every joint tells when a trial began, and with it what every other joint does."""
    data = plays([_begun_late(r) for r in recordings])
    assert not any(data.begun(r) for r in data.recordings)
    true = [
        ActiveEffect.of("servo_lag", None, lag=LAG),
        ActiveEffect.of("lagging_joint", 2, lag=0.03),
        ActiveEffect.of("gain_loss", 2, loss=0.1),
        ActiveEffect.of("gain_loss", 5, loss=0.2),
    ]
    noise = np.random.default_rng(1).normal(0, data.noise, data.readings.shape)
    data = replace(data, readings=data.realised(true) + noise)
    begun = [e.with_coordinates([0.7 * e.coordinates[0]]) for e in true]
    found = fit_together(data, begun)
    assert [e.key for e in found] == [e.key for e in true]
    for e, t in zip(found, true, strict=True):
        assert e.coordinates[0] == pytest.approx(t.coordinates[0], rel=0.03)
    assert data.chi2(data.realised(found)).sum() <= data.chi2(data.realised(true)).sum()


def test_servos_are_expected_to_do_the_same_whether_their_lag_is_found_or_known(
    recordings: tuple[Recording, ...],
) -> None:
    """Of a reference it is known; between two rows servos are followed all the same."""
    data, lag = plays(recordings), ActiveEffect.of("servo_lag", None, lag=LAG)
    found = carried(recordings, data, [lag])
    known = carried(recordings, replace(data, known=(lag,)), [])
    for one, other in zip(found, known, strict=True):
        np.testing.assert_array_equal(one.log_time, other.log_time)
        np.testing.assert_array_equal(one.angles_at(one.time), other.angles_at(other.time))
