"""A law of the servos whose number runs from trial to trial is told as that, with its numbers."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.folder import write
from blind.schedule import lagged
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.shapes.course import Course
from serpenoid.diagnose.stages.actuation.choose_actuation import choose_actuation
from serpenoid.diagnose.stages.actuation.choose_set_points import plays
from serpenoid.diagnose.stages.actuation.law_by_trial import law_by_trial, of_trial
from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.diagnose.stages.by_trial import by_gait
from serpenoid.effects.active import ActiveEffect
from serpenoid.measure.logs import TICK

LAG = ActiveEffect.neutral("servo_lag").with_coordinates([0.05])


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> tuple[Recording, ...]:
    folder = tmp_path_factory.mktemp("servos")
    write(make(71, [], combinations=COMBINATIONS[:2]), folder)
    return read_recordings(folder)[1]


def lagging(recordings: tuple[Recording, ...], lags: list[float]) -> Plays:
    """Servos that follow rows that run with a lag [s] of its own in each trial; when they were told so is known."""
    rng = np.random.default_rng(4)

    def late(r: Recording, lag: float) -> Recording:
        r = replace(r, schedule=replace(r.schedule, held=False), told=None, commands=None, t0_spread=0.0)
        time = np.arange(r.read_at[0], r.read_at[-1] + 1e-3, 1e-3)
        done = Course(time, lagged(time, r.schedule.commanded(time), np.full(len(time) - 1, lag))).at(r.read_at)
        return replace(r, position=TICK * np.round(done / TICK + 0.4 * rng.normal(size=done.shape)))

    return replace(plays([late(r, lag) for r, lag in zip(recordings, lags, strict=True)], held=False), told=True)


GROWING = [0.03, 0.05, 0.07, 0.09]


def test_a_lag_that_grows_is_told_with_its_first_and_last_value(recordings: tuple[Recording, ...]) -> None:
    data = lagging(recordings, GROWING)
    found = law_by_trial(data, [LAG], [LAG])
    assert found is not None
    assert found.steady
    first, last = data.recordings[0].name, data.recordings[-1].name
    told = re.fullmatch(
        rf"servo_lag changes steadily from trial to trial: lag ([\d.]+) s in `{first}`, ([\d.]+) s in `{last}`",
        found.words,
    )
    assert told is not None
    assert [float(x) for x in told.groups()] == pytest.approx([GROWING[0], GROWING[-1]], rel=0.05)


@pytest.mark.slow
def test_it_divides_trials_into_no_two_sides(recordings: tuple[Recording, ...]) -> None:
    found = choose_actuation(lagging(recordings, GROWING))
    assert found.divided is not None
    assert not found.divided.changed
    assert "changes steadily from trial to trial" in found.divided.words
    assert found.divided.words in found.words


@pytest.mark.parametrize("lags", [[0.02, 0.03, 0.09, 0.1], [0.09, 0.03, 0.07, 0.05]])
def test_a_step_or_a_scatter_is_no_steady_change(recordings: tuple[Recording, ...], lags: list[float]) -> None:
    found = law_by_trial(lagging(recordings, lags), [LAG], [LAG])
    assert found is not None
    assert not found.steady
    assert found.words.startswith("servo_lag differs from trial to trial: ")


def test_two_values_that_go_with_gaits_divide_no_trials(recordings: tuple[Recording, ...]) -> None:
    """A servo that is weak under load lags more in one gait than in another: no law, and no trial that changed."""
    by_round = tuple(recordings[i] for i in (0, 2, 1, 3))
    assert by_round[0].setting == by_round[2].setting != by_round[1].setting
    found = law_by_trial(lagging(by_round, [0.03, 0.11, 0.045, 0.125]), [LAG], [LAG])
    assert found is not None
    assert found.divided is None
    assert found.words.startswith("servo_lag differs from gait to gait: ")
    assert found.of_others(["servo_lag would leave 35%: not its law"])


@pytest.mark.parametrize(("sides", "gaits"), [("abab", True), ("aabb", False), ("abba", False), ("abaa", False)])
def test_gaits_are_told_from_a_moment(sides: str, gaits: bool) -> None:
    names = ["one-1", "two-1", "one-2", "two-2"]
    changed = [n for n, side in zip(names, sides, strict=True) if side == "b"]
    assert by_gait(changed, names, ["one", "two", "one", "two"]) is gaits


def test_what_weakens_every_joint_alike_is_told_of_all_together(recordings: tuple[Recording, ...]) -> None:
    """A battery that sags: one joint's law leaves what the others' do, and all of them leave nothing."""

    def weak(r: Recording, loss: float) -> Recording:
        rng = np.random.default_rng(5)
        r = replace(r, schedule=replace(r.schedule, held=False), told=None, commands=None, t0_spread=0.0)
        done = (1 - loss) * r.schedule.commanded(r.read_at)
        return replace(r, position=TICK * np.round(done / TICK + 0.4 * rng.normal(size=done.shape)))

    losses = [0.05, 0.1, 0.15, 0.2]
    played = [weak(r, loss) for r, loss in zip(recordings, losses, strict=True)]
    data = replace(plays(played, held=False), told=True)
    joints = range(1, data.readings.shape[1] + 1)
    suspects = [ActiveEffect.neutral("gain_loss", j).with_coordinates([0.1]) for j in joints]
    found = law_by_trial(data, [], suspects)
    assert found is not None
    assert found.steady
    assert found.called == tuple(e.called for e in suspects)
    first, last = (r.name for r in (data.recordings[0], data.recordings[-1]))
    how = "changes steadily from trial to trial"
    assert found.words == f"gain_loss at all joints {how}: loss 0.05 in `{first}`, 0.2 in `{last}` in the mean"


def test_a_law_that_all_trials_share_does_not_differ(recordings: tuple[Recording, ...]) -> None:
    data = lagging(recordings, [0.05] * 4)
    assert law_by_trial(data, [LAG], [LAG]) is None
    assert law_by_trial(data, [], []) is None


def test_trials_alone_are_all_of_the_data(recordings: tuple[Recording, ...]) -> None:
    data = plays(recordings)
    parts = [of_trial(data, t) for t in range(len(data.recordings))]
    assert np.array_equal(np.concatenate([p.readings for p in parts]), data.readings, equal_nan=True)
    played = data.realised([LAG])
    whole = sum(p.chi2(p.realised([LAG])) for p in parts)
    assert whole == pytest.approx(data.chi2(played), rel=1e-9)
