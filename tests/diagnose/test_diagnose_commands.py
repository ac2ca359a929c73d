"""What a log's own commands tell: when a trial began, whether rows are held, and with these how late servos are."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from blind.protocol import usual, with_joints
from blind.schedule import lagged
from serpenoid.body import Floats
from serpenoid.diagnose.data.recordings.clocks import Clock
from serpenoid.diagnose.data.recordings.played import _words, by_their_commands
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import UNSURE_CYCLE, Recording
from serpenoid.diagnose.data.recordings.told import Distances, told_by_commands
from serpenoid.diagnose.stages.actuation.choose_actuation import choose_actuation
from serpenoid.diagnose.stages.actuation.choose_set_points import plays
from serpenoid.diagnose.stages.actuation.expected import carried, expected
from serpenoid.diagnose.stages.actuation.set_points import ways
from serpenoid.effects.active import ActiveEffect
from serpenoid.measure.campaign import load_campaign_file
from serpenoid.measure.logs import TICK, ServoLog
from serpenoid.measure.schedule import Schedule

CYCLE_S, PAUSE_S, CYCLES, START_S, ROWS, JOINTS = 4.0, 1.0, 2, 1.2345, 40, 6
FINE_S = 1e-3


@pytest.fixture(scope="module")
def trial(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    folder = tmp_path_factory.mktemp("commands")
    write(make(72, [], protocol=with_joints(usual(72, COMBINATIONS[:1]), JOINTS)), folder)
    return read_recordings(folder)[1][0]


def square(joints: int, held: bool = False) -> Schedule:
    """Strokes of one half of the joints after the other; t0 is START_S."""
    corners = 0.7 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]])
    two = np.stack([np.interp(4 * np.arange(ROWS) / ROWS, range(5), c) for c in corners.T], axis=1)
    return Schedule(two[:, np.arange(joints) % 2], CYCLE_S, CYCLES, PAUSE_S, START_S, held)


def logged(schedule: Schedule, hertz: float, command: Floats | None = None) -> ServoLog:
    time = np.arange(0, schedule.end_s + 0.5, 1 / hertz)
    told = np.round(schedule.commanded(time) / TICK) * TICK if command is None else command
    return ServoLog(time, told, told, None, None, None, {}, "log.csv")


def slow(r: Recording, hertz: float, lag: float, says_commands: bool) -> Recording:
    """A trial of straight strokes, and servos that follow them late, in a log without labels."""
    plan = square(r.body.joint_count)
    log, fine = logged(plan, hertz), np.arange(0, plan.end_s + 1, FINE_S)
    late = lagged(fine, plan.commanded(fine), np.full(len(fine) - 1, lag))
    read = np.stack([np.interp(log.time_s, fine, c) for c in late.T], axis=1)
    read = read + np.random.default_rng(3).normal(0, TICK, read.shape)
    told = told_by_commands(log, replace(plan, start_s=0.0), 0.0) if says_commands else None
    start, spread = (told.start_s, told.spread_s) if told else (START_S + lag, UNSURE_CYCLE * CYCLE_S)
    return replace(
        r, schedule=replace(plan, start_s=0.0), log_time=log.time_s - start, position=read, t0_spread=spread,
        commands=log.command if says_commands else None, told=told, asked_cycle_s=None,
    )  # fmt: skip


@pytest.mark.parametrize("renewed_hertz", [200, 400])
def test_commands_that_are_renewed_now_and_then_leave_the_start_open_by_as_much(renewed_hertz: float) -> None:
    """A log that reads them at its own times finds each late by anything up to that interval."""
    plan = square(JOINTS)
    time = logged(plan, 21.0).time_s
    log = logged(plan, 21.0, plan.commanded(np.floor(time * renewed_hertz) / renewed_hertz))
    told = told_by_commands(log, replace(plan, start_s=0.0), 0.0)
    assert told is not None
    assert START_S < told.start_s < START_S + 1 / renewed_hertz
    assert told.start_s - told.spread_s < START_S
    assert told.spread_s < 1 / renewed_hertz


@pytest.mark.parametrize(
    ("held", "hertz", "open_s"), [(False, 10, 1e-3), (False, 20, 1e-3), (True, 20, 0.026), (True, 33, 2e-3)]
)
def test_commands_say_when_a_trial_began_and_whether_rows_are_held(held: bool, hertz: float, open_s: float) -> None:
    plan = square(2, held)
    told = told_by_commands(logged(plan, hertz), replace(plan, start_s=0.0, held=False), 0.0)
    assert told is not None
    assert told.held == held
    assert abs(told.start_s - START_S) < told.spread_s < open_s


def test_commands_that_are_not_the_table_or_are_it_in_both_ways_say_nothing() -> None:
    plan = square(2)
    asked, log = replace(plan, start_s=0.0), logged(plan, 50)
    assert log.command is not None
    clipped = logged(plan, 50, np.clip(log.command, -0.6, 0.6))
    assert told_by_commands(clipped, asked, 0.0) is None
    rows = logged(replace(plan, held=True, start_s=1.2), ROWS / CYCLE_S)  # one row of the log for one of the table
    assert told_by_commands(rows, asked, 0.0) is None
    assert told_by_commands(replace(log, command=None), asked, 0.0) is None


@pytest.mark.parametrize("lag", [0.03, 0.08])
def test_the_commands_of_a_slow_log_tell_a_lag_from_a_late_start_and_from_held_rows(
    trial: Recording, lag: float
) -> None:
    data = plays([slow(trial, 20, lag, True)])
    assert not data.held
    (named,) = choose_actuation(data).named
    assert named.effect.key == ("servo_lag", None)
    low, high = named.intervals["lag"]
    assert low is not None
    assert high is not None
    assert low < lag < high
    assert high - low < 0.012


def test_servos_are_followed_between_the_rows_of_a_slow_log_that_does_not_say_when_a_trial_began(
    trial: Recording,
) -> None:
    recorded = slow(trial, 10, 0.05, False)
    assert recorded.lag_untold
    assert not slow(trial, 10, 0.05, True).lag_untold
    data, lag = next(ways([recorded])), 0.05
    left = data.left(data.realised([ActiveEffect.of("servo_lag", None, lag=lag)]))
    np.testing.assert_allclose(left.std(), TICK, rtol=0.05)  # the noise of a reading


def told_goals(r: Recording, hertz: float, lag: float, runs: bool = True, missing: float = 0.0) -> Recording:
    """A trial whose log has row i + 1 as commanded when row i is due, and servos that run there until the next is, or
    (not `runs`) jump at once; missing: a share of what was read, and of what was commanded."""
    plan = square(r.body.joint_count)
    given = replace(plan, held=True, start_s=START_S - plan.row_s)
    log, fine = logged(given, hertz), np.arange(0, plan.end_s + 1, FINE_S)
    late = lagged(fine, (plan if runs else given).commanded(fine), np.full(len(fine) - 1, lag))
    read = np.stack([np.interp(log.time_s, fine, c) for c in late.T], axis=1)
    random = np.random.default_rng(4)
    read = np.where(random.random(read.shape) < missing, np.nan, read + random.normal(0, TICK, read.shape))
    log = replace(log, command=np.where(random.random((len(read), 1)) < missing, np.nan, log.command))
    told = told_by_commands(log, replace(plan, start_s=0.0), 0.0, START_S)
    assert told is not None
    return replace(
        r, schedule=replace(plan, start_s=0.0), time=r.time - r.time[0], log_time=log.time_s - told.start_s,
        position=read, t0_spread=told.spread_s, commands=log.command, told=told, asked_cycle_s=None,
    )  # fmt: skip


def begins_s(r: Recording) -> float:
    """t0 on the log's clock, whose first row is at 0."""
    return float(-r.log_time[0])


def test_held_rows_may_be_goals_unless_labels_say_that_they_were_due_as_they_were_commanded() -> None:
    plan = square(2, held=True)
    log, asked = logged(plan, 50), replace(plan, start_s=0.0, held=False)

    def goals(labelled: float | None, log: ServoLog = log) -> bool:
        told = told_by_commands(log, asked, 0.0, labelled)
        assert told is not None
        return told.goals

    assert goals(None)
    assert goals(START_S + plan.row_s)
    assert not goals(START_S + 0.02)  # late by a row of the log
    assert not goals(START_S + plan.row_s, logged(square(2), 50))  # commands that run


@pytest.mark.parametrize(("hertz", "missing"), [(50, 0.0), pytest.param(20, 0.0, marks=pytest.mark.slow), (20, 0.2)])
def test_commands_may_be_goals_that_are_run_to_until_the_next(trial: Recording, hertz: float, missing: float) -> None:
    lag, told = 0.03, told_goals(trial, hertz, 0.03, missing=missing)
    assert told.held_as_told
    data = plays([told])
    assert data.goals
    assert not data.held
    (named,) = choose_actuation(data).named
    assert named.effect.key == ("servo_lag", None)
    low, high = named.intervals["lag"]
    assert low is not None
    assert high is not None
    assert low < lag < high
    (found,) = carried([told], data, [named.effect])
    assert begins_s(found) == pytest.approx(START_S, abs=told.unsure_start)
    assert found.schedule == replace(told.schedule, held=False)


def test_goals_are_taken_once_and_back(trial: Recording) -> None:
    told = told_goals(trial, 50, 0.03)
    once = told.taken(held=False, goals=True)
    np.testing.assert_allclose(told.read_at - once.read_at, told.schedule.row_s, rtol=1e-9)  # rounding
    np.testing.assert_allclose(told.time - once.time, told.schedule.row_s, rtol=1e-9)
    np.testing.assert_array_equal(once.taken(held=False, goals=True).log_time, once.log_time)
    np.testing.assert_allclose(once.taken(held=True, goals=False).time, told.time, atol=1e-12)  # rounding
    untold = replace(told, told=None)  # nothing says that its commands jump
    np.testing.assert_array_equal(untold.taken(held=False, goals=True).log_time, told.log_time)


def test_what_servos_are_expected_to_do_is_on_the_clock_of_the_recordings_it_is_asked_of(trial: Recording) -> None:
    told = told_goals(trial, 50, 0.03)
    data = plays([told])
    effects = [n.effect for n in choose_actuation(data).named]
    (found,), (course,) = carried([told], data, effects), expected([told], data, effects)
    (later,) = expected([found], data, effects)
    np.testing.assert_allclose(course.at(told.read_at), later.at(found.read_at), atol=TICK / 10)  # t0 met again
    inside = (found.read_at > 0) & (found.read_at < found.schedule.moving_s)
    assert np.std(told.position[inside] - course.at(told.read_at)[inside]) < 1.5 * TICK  # the noise of a reading


@pytest.mark.parametrize(
    ("hertz", "lag", "missing"),
    [
        (20, 0.06, 0.0),
        *(pytest.param(50, *of, marks=pytest.mark.slow) for of in ((0.02, 0.0), (0.06, 0.0))),
        (50, 0.06, 0.2),
    ],
)
def test_rows_that_are_held_as_commanded_are_no_goals(
    trial: Recording, hertz: float, lag: float, missing: float
) -> None:
    told = told_goals(trial, hertz, lag, runs=False, missing=missing)
    data = plays([told])
    assert data.held
    assert not data.goals
    (named,) = choose_actuation(data).named
    assert named.effect.key == ("servo_lag", None)
    (found,) = carried([told], data, [named.effect])
    assert begins_s(found) == pytest.approx(START_S - told.schedule.row_s, abs=told.unsure_start)


@pytest.mark.parametrize("held", [False, True])
def test_squares_by_distances_from_rows_are_those_of_what_is_commanded(held: bool) -> None:
    plan = square(3, held)
    command = np.random.default_rng(5).normal(0, 0.5, (60, 3))
    times = np.linspace(-1, plan.end_s + 1, 60) + np.linspace(0, 0.3, 7)[:, None]  # before, in pauses, after the end
    direct = [((command - plan.commanded(time)) ** 2).sum() for time in times]
    np.testing.assert_allclose(Distances.of(command, plan.closed).squares(plan, times), direct, rtol=1e-12)  # rounding


@pytest.mark.parametrize("hertz", [8, 12])
def test_a_start_is_as_open_as_commands_leave_it_about_every_rate_of_the_clock(hertz: float) -> None:
    """Rows that jump, in a slow log, exclude neither that its clock runs as the cameras' nor what noisy markers say."""
    plan = square(2, held=True)
    log, asked, rate = logged(plan, hertz), replace(plan, start_s=0.0, held=False), 2e-3
    alone, told = told_by_commands(log, asked, 0.0), told_by_commands(log, asked, rate)
    assert alone is not None
    assert told is not None
    assert abs(told.start_s - START_S) < told.spread_s
    assert told.spread_s > alone.spread_s


FILM = -0.01  # rate of the log's clock beside the film's


@pytest.mark.parametrize("by_log", [True, False])
def test_commands_say_whose_clock_they_follow(by_log: bool) -> None:
    """Two clocks that differ by 1 %: at the end of a trial by a row of the table."""
    plan = square(2)
    log, asked = logged(plan, 50), replace(plan, start_s=0.0)
    told = told_by_commands(log if by_log else replace(log, time_s=log.time_s * (1 + FILM)), asked, FILM)
    assert told is not None
    assert told.by_log == by_log
    assert told.start_s == pytest.approx(START_S * (1.0 if by_log else 1 + FILM), abs=2e-3)


def filmed(trial: Recording, log_rate: float, sd: float, lag: float = 0.05) -> Recording:
    """A trial whose commands keep to the log's clock, beside which the film runs at another rate."""
    fast = slow(trial, 50, lag, True)
    time = np.arange(0, fast.log_time[-1], 0.02) / (1 + log_rate)
    markers = np.full((len(time), trial.body.vertices, 2), np.nan)
    return replace(fast, time=time, markers=markers, clock=Clock(0.0, log_rate, sd, sd))


def test_cycles_are_as_long_on_a_wrong_film_as_the_log_has_them_and_no_servo_is_late_for_it(trial: Recording) -> None:
    trials = by_their_commands([filmed(trial, FILM, 1e-5)])
    assert trials[0].schedule.cycle_duration_s == pytest.approx(CYCLE_S / (1 + FILM), rel=1e-9)
    assert "so the film's is wrong" in trials[0].remarks[-1].words
    assert trials[0].setting == (trial.gait, CYCLE_S)  # the same setting as on a film that is right
    (named,) = choose_actuation(plays(trials)).named
    assert named.effect.key == ("servo_lag", None)
    low, high = named.intervals["lag"]
    assert low is not None
    assert high is not None
    assert low < 0.05 / (1 + FILM) < high  # in seconds of the film


def test_a_trial_whose_commands_do_not_say_when_rows_were_due_follows_the_others(trial: Recording) -> None:
    one, unclear = filmed(trial, FILM, 1e-5), replace(filmed(trial, FILM, 1e-5), told=None)
    own, found = by_their_commands([one, replace(unclear, commands=one.position)])
    assert found.schedule.cycle_duration_s == own.schedule.cycle_duration_s != trial.schedule.cycle_duration_s
    assert found.remarks == own.remarks
    _, without = by_their_commands([one, replace(unclear, commands=None)])
    assert without.schedule is unclear.schedule


@pytest.mark.parametrize("rate", [-0.03, 2.4e-5])
def test_cycles_on_a_film_are_told_with_as_many_digits_as_tell_them_from_the_promise(rate: float) -> None:
    recording: Any = SimpleNamespace(by_servos=True, clock=Clock(0.0, 0.0, 0.0, 0.0))
    said = _words(recording, rate, [6.0, 8.0])
    on_film, promised = re.findall(r"[\d.]+, [\d.]+", said)[:2]
    for film, asked in zip(on_film.split(", "), promised.split(", "), strict=True):
        assert float(film) / float(asked) - 1 == pytest.approx(rate, rel=0.1)
    assert f"{100 * abs(rate):.2g} % " in said


def test_a_rate_that_noisy_markers_make_is_no_wrong_film(trial: Recording) -> None:
    """Commands and readings stay together on the log's clock all the same."""
    (found,) = by_their_commands([filmed(trial, 2e-3, 1e-3)])
    assert found.remarks == trial.remarks
    assert found.schedule.cycle_duration_s == pytest.approx(CYCLE_S / 1.002, rel=1e-9)


def test_a_rate_that_a_displaced_marker_may_make_is_no_wrong_film(trial: Recording) -> None:
    """Cycles are moved by what is likeliest; nobody's clock is charged."""
    film = filmed(trial, FILM, 1e-5)
    (found,) = by_their_commands([replace(film, clock=replace(film.clock, apart=(FILM, 0.5 * abs(FILM))))])
    assert found.remarks == trial.remarks
    (found,) = by_their_commands([replace(film, clock=replace(film.clock, apart=(FILM, 0.1 * abs(FILM))))])
    assert "so the film's is wrong" in found.remarks[-1].words


def test_where_commands_of_one_trial_follow_the_film_alone_nothing_is_moved(trial: Recording) -> None:
    one, other = filmed(trial, FILM, 1e-5), filmed(trial, FILM, 1e-5)
    assert other.told is not None
    trials = (one, replace(other, told=replace(other.told, by_log=False)))
    assert by_their_commands(trials) == trials


def test_a_log_that_repeats_its_commands_says_nothing_of_servos_and_a_note_says_so(tmp_path: Path) -> None:
    few = with_joints(usual(5, COMBINATIONS[:1]), JOINTS)
    write(make(5, [Effect("servo_lag", None, {"lag": 0.1})], protocol=few), tmp_path)
    file, folder = load_campaign_file(tmp_path)
    for log in [folder / str(t.servo_log) for t in file.trial]:
        header, *rows = [line.split(",") for line in log.read_text().splitlines()]
        told = {name.removeprefix("command_"): i for i, name in enumerate(header) if name.startswith("command_")}
        read = {
            i: told[name.removeprefix("position_")] for i, name in enumerate(header) if name.startswith("position_")
        }
        copied = [[row[read.get(i, i)] for i in range(len(row))] for row in rows]
        log.write_text("\n".join(",".join(row) for row in (header, *copied)) + "\n")
    recordings = read_recordings(tmp_path)[1]
    assert not any(r.by_servos for r in recordings)
    assert all(any("positions are its commands" in remark.words for remark in r.remarks) for r in recordings)
    (named,) = choose_actuation(plays(recordings)).named  # the lag that markers show
    assert named.effect.name == "servo_lag"
