"""Servos of second order are named by their lag and damping; those of first order have no second number."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from blind.protocol import usual, with_joints
from blind.schedule import lagged, swung
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import UNSURE_CYCLE, Recording
from serpenoid.diagnose.data.shapes.course import Course
from serpenoid.diagnose.inference.fits.finding import Named, Stage
from serpenoid.diagnose.stages.actuation.actuation_by_joint import attempts, fit_everywhere
from serpenoid.diagnose.stages.actuation.actuation_search import Played, one_more
from serpenoid.diagnose.stages.actuation.choose_actuation import choose_actuation
from serpenoid.diagnose.stages.actuation.choose_set_points import plays
from serpenoid.effects import ActiveEffect, find
from serpenoid.measure.logs import TICK

SEED, JOINTS = 71, 6
Play = Callable[[np.ndarray, np.ndarray], np.ndarray]


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> tuple[Recording, ...]:
    folder = tmp_path_factory.mktemp("inertia")
    write(make(SEED, [], protocol=with_joints(usual(SEED, COMBINATIONS[:2]), JOINTS)), folder)
    return read_recordings(folder)[1]


def logged(recordings: tuple[Recording, ...], play: Play, noise: float = 0.4 * TICK) -> list[Recording]:
    """Recordings whose servos make of what they are told, at every millisecond (n, m), what `play` makes."""
    rng = np.random.default_rng(4)

    def one(r: Recording) -> Recording:
        time = np.arange(r.read_at[0], r.read_at[-1] + 1e-3, 1e-3)
        done = Course(time, play(time, r.schedule.commanded(time))).at(r.read_at)
        return replace(r, position=TICK * np.round((done + noise * rng.normal(size=done.shape)) / TICK))

    return [one(r) for r in recordings]


def inertia(lag: float, damping: float) -> Play:
    return lambda time, told: swung(time, told, lag, damping)


def alone(stage: Stage) -> Named:
    """What is named alone, with nothing in its place, no mark, and nothing left."""
    assert stage.settled
    assert not stage.rivals
    (named,) = stage.named
    assert not named.stand_in
    return named


def assert_known(named: Named, **truth: float) -> None:
    """Intervals hold the truth and are narrow beside it."""
    for name, value in truth.items():
        low, high = named.intervals[name]
        assert low is not None
        assert high is not None
        assert low < value < high
        assert high - low < 0.25 * value


@pytest.mark.parametrize(
    ("lag", "damping"),
    [(0.08, 0.3), *(pytest.param(*law, marks=pytest.mark.slow) for law in ((0.05, 0.7), (0.15, 1.2)))],
)
def test_servos_that_overshoot_or_creep_have_a_lag_and_a_damping(
    recordings: tuple[Recording, ...], lag: float, damping: float
) -> None:
    named = alone(choose_actuation(plays(logged(recordings, inertia(lag, damping)))))
    assert named.effect.key == ("servo_inertia", None)
    assert_known(named, lag=lag, damping=damping)


@pytest.mark.slow
def test_servos_that_ring_after_every_row_that_jumps_have_inertia(tmp_path: Path) -> None:
    hidden = Effect("servo_inertia", None, {"lag": 0.05, "damping": 0.4})
    protocol = replace(with_joints(usual(SEED, COMBINATIONS[:1]), JOINTS), held=True)
    write(make(SEED, [hidden], protocol=protocol), tmp_path)
    data = plays(read_recordings(tmp_path)[1])
    assert data.held
    named = alone(choose_actuation(data))
    assert named.effect.key == (hidden.name, None)
    assert_known(named, **hidden.parameters)


@pytest.mark.parametrize("lag", [0.02, pytest.param(0.1, marks=pytest.mark.slow)])
def test_servos_of_first_order_have_a_lag_and_no_damping(recordings: tuple[Recording, ...], lag: float) -> None:
    """Of which a lag is the limit: it fits no better, for one more number, and is no rival."""
    servos = logged(recordings, lambda time, told: lagged(time, told, np.full(len(time) - 1, lag)))
    data = plays(servos)
    named = alone(choose_actuation(data))
    assert named.effect.key == ("servo_lag", None)
    assert_known(named, lag=lag)
    by_name = {a.effect.name: a for a in attempts(data, []) if a.effect.place is None}
    gain = by_name["servo_lag"].chi2.sum() - by_name["servo_inertia"].chi2.sum()
    assert gain < np.log(data.often.sum())  # the price of one more number


@pytest.mark.parametrize(("damping", "name"), [(np.inf, "servo_lag"), (0.6, "servo_inertia")])
def test_a_fit_that_came_less_far_is_no_reason_for_one_more_number(
    recordings: tuple[Recording, ...], damping: float, name: str
) -> None:
    """Both laws near where their fits begin; the one with two numbers is said to leave much less."""

    def play(time: np.ndarray, told: np.ndarray) -> np.ndarray:
        if np.isfinite(damping):
            return swung(time, told, 0.1, damping)
        return lagged(time, told, np.full(len(time) - 1, 0.1))

    tries = [ActiveEffect.of("servo_lag", lag=0.03), ActiveEffect.of("servo_inertia", lag=0.05, damping=1.0)]
    new, best = one_more(Played(plays(logged(recordings, play))), tries, [1e9, 1e6], 1)
    assert (new.name, [e.name for e in best.effects]) == (name, [name])


def test_servos_that_do_as_they_are_told_have_neither(recordings: tuple[Recording, ...]) -> None:
    stage = choose_actuation(plays(logged(recordings, lambda time, told: told)))
    assert stage.settled
    assert not stage.named


@pytest.mark.slow
def test_inertia_is_told_from_a_late_start_where_nothing_says_when_a_trial_began(
    recordings: tuple[Recording, ...],
) -> None:
    lag, damping, late, noise = 0.15, 0.5, 0.12, 0.01
    rng = np.random.default_rng(2)

    def filmed(r: Recording) -> Recording:
        true = swung(r.read_at, r.schedule.commanded(r.read_at + late), lag, damping)
        unsure = UNSURE_CYCLE * r.schedule.cycle_duration_s
        return replace(r, position=true + noise * rng.normal(size=true.shape), by_servos=False, t0_spread=unsure)

    named = alone(choose_actuation(plays([filmed(r) for r in recordings])))
    assert named.effect.key == ("servo_inertia", None)
    assert_known(named, lag=lag, damping=damping)


def test_a_fit_of_two_numbers_ends_at_the_same_place_from_far_starts(recordings: tuple[Recording, ...]) -> None:
    data = plays(logged(recordings, inertia(0.08, 0.5)))
    joints, damping = data.readings.shape[1], find("servo_inertia").parameters[1]
    found = []
    for lag, d in ((0.01, 0.3), (0.05, 1.0), (0.2, 2.0)):
        start = np.tile([[lag], [damping.coordinate(d)]], (1, joints))
        for _ in range(3):  # a start may be farther off than one fit goes
            (attempt,) = fit_everywhere(data, "servo_inertia", [], [start])
            start = np.tile(np.array(attempt.effect.coordinates[:-1])[:, None], (1, joints))
        found.append([attempt.effect.parameters[p] for p in ("lag", "damping")])
    np.testing.assert_allclose(found, [found[0]] * 3, rtol=1e-3)
