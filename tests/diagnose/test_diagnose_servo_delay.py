"""Servos that do everything late by the same time are named by it, beside what else they do, and no start is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.folder import write
from blind.schedule import delayed, lagged, swung
from blind.study import Study
from diagnose.test_diagnose_servo_inertia import SEED, Play, alone, logged
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import UNSURE_CYCLE, Recording
from serpenoid.diagnose.inference.fits.finding import Stage
from serpenoid.diagnose.stages.actuation.choose_actuation import choose_actuation
from serpenoid.diagnose.stages.actuation.choose_set_points import plays


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> tuple[Recording, ...]:
    folder = tmp_path_factory.mktemp("delay")
    write(make(SEED, [], combinations=COMBINATIONS[:2]), folder)
    return read_recordings(folder)[1]


def late(delay: float, lag: float = 0.0, damping: float = np.inf) -> Play:
    """Told later, and then with a lag, or inertia."""

    def play(time: np.ndarray, told: np.ndarray) -> np.ndarray:
        told = delayed(time, told, delay)
        if np.isfinite(damping):
            return swung(time, told, lag, damping)
        return lagged(time, told, np.full(len(time) - 1, lag)) if lag else told

    return play


def assert_both(stage: Stage, **truth: dict[str, float]) -> None:
    """All these are named, nothing else, and nothing is left."""
    assert stage.settled
    assert {n.effect.name for n in stage.named} == set(truth)
    for named in stage.named:
        assert not named.stand_in
        for name, value in truth[named.effect.name].items():
            low, high = named.intervals[name]
            assert low is not None
            assert high is not None
            assert low < value < high


@pytest.mark.parametrize("delay", [0.06, *(pytest.param(d, marks=pytest.mark.slow) for d in (0.015, 0.2))])
def test_servos_that_do_everything_late_have_a_delay(recordings: tuple[Recording, ...], delay: float) -> None:
    named = alone(choose_actuation(plays(logged(recordings, late(delay)))))
    assert named.effect.key == ("servo_delay", None)
    low, high = named.intervals["delay"]
    assert low is not None
    assert high is not None
    assert low < delay < high
    assert high - low < 0.005  # trials may begin 2 ms later than a log says


@pytest.mark.parametrize("lag", [0.03, pytest.param(0.1, marks=pytest.mark.slow)])
def test_a_lag_beside_a_delay_is_no_inertia(recordings: tuple[Recording, ...], lag: float) -> None:
    """Of as many numbers, that leaves no more than one can see."""
    stage = choose_actuation(plays(logged(recordings, late(0.03, lag))))
    assert_both(stage, servo_delay={"delay": 0.03}, servo_lag={"lag": lag})


@pytest.mark.slow
def test_inertia_beside_a_delay_is_no_longer_delay(recordings: tuple[Recording, ...]) -> None:
    stage = choose_actuation(plays(logged(recordings, late(0.06, 0.08, 0.7))))
    assert_both(stage, servo_delay={"delay": 0.06}, servo_inertia={"lag": 0.08, "damping": 0.7})


def test_where_nothing_says_when_a_trial_began_a_delay_is_a_late_start(recordings: tuple[Recording, ...]) -> None:
    """And no inertia either."""

    def untold(r: Recording) -> Recording:
        unsure = UNSURE_CYCLE * r.schedule.cycle_duration_s
        return replace(r, commands=None, told=None, t0_spread=unsure)

    stage = choose_actuation(plays([untold(r) for r in logged(recordings, late(0.06))]))
    assert stage.settled
    assert not stage.named


def test_trials_may_each_be_late_by_a_time_of_their_own(recordings: tuple[Recording, ...]) -> None:
    """The last trials read what was commanded 34 ms before."""
    data = plays([replace(r, log_time=r.log_time + 0.034 * (i > 1)) for i, r in enumerate(recordings)])
    assert not data.held
    assert (data.channels(data.each_later()) < 1.1).all()
    assert (data.channels(data.realised([])) > 5).all()


@pytest.mark.slow  # a campaign of sixteen trials
def test_a_delay_that_begins_amid_a_campaign_takes_no_rows_for_held(tmp_path: Path) -> None:
    """34 ms in the last five trials: held rows are half a row late, in between, and were said to be what servos follow
    in all but one."""
    case = Study("amid", tmp_path, None, key="gates-48").case(14)
    write(case.campaign, tmp_path / "case")
    data = plays(read_recordings(tmp_path / "case")[1])
    assert not data.held
    stage = choose_actuation(data)
    assert stage.divided is not None
    assert stage.divided.changed == tuple(f"gait{n:02}-a-2" for n in range(4, 9))
