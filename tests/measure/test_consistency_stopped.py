"""Robots that stop before their trial is over."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.measure.consistency.check import check
from serpenoid.measure.consistency.claim import Claim
from serpenoid.measure.consistency.signals import Signal
from serpenoid.measure.schedule import Schedule

CYCLE_S, PAUSE_S, CYCLES, ROWS = 3.0, 0.5, 3, 40


def schedule() -> Schedule:
    phase = 2 * np.pi * np.arange(ROWS)[:, None] / ROWS + np.array([0.0, 1.0, 2.0, 3.0])
    return Schedule(0.5 * np.sin(phase) + 0.1 * np.cos(2 * phase), CYCLE_S, CYCLES, PAUSE_S, 0.0)


def seen(stops_s: float, film_s: float = CYCLES * (CYCLE_S + PAUSE_S)) -> Signal:
    """What a camera sees of a robot that stops so many seconds after the beginning; the film begins 1.2 s earlier."""
    rng, time = np.random.default_rng(3), np.arange(-1.2, film_s, 1 / 60)
    angles = schedule().commanded(np.minimum(time, stops_s))
    return Signal(time + 1.2, angles + rng.normal(0, 5e-3, angles.shape))


def checked(cameras: Signal | None, servos: Signal | None = None, commands: Signal | None = None) -> list[str]:
    claim = Claim("a", "gait.csv", schedule(), cameras, servos, commands)
    return [f"{c.kind}: {c.words}. {c.cure}" for c in check([claim], {"gait.csv": schedule().table}).contradictions]


@pytest.mark.parametrize(
    "stops_s", [pytest.param(2.2, marks=pytest.mark.slow), pytest.param(4.9, marks=pytest.mark.slow), 6.1]
)
def test_a_robot_that_stops_amid_its_motion_is_told_with_the_moment(stops_s: float) -> None:
    (said,) = checked(seen(stops_s))
    assert said.startswith("stopped: ")
    told = float(said.split("`to_s = ")[1].split("`")[0])
    assert told == pytest.approx(1.2 + stops_s, abs=0.15)


def test_by_its_servos_alone_the_trial_is_left_out() -> None:
    (said,) = checked(None, seen(4.9))
    assert "Leave this trial out" in said


def test_what_was_told_to_stop_is_known() -> None:
    assert not checked(None, seen(4.9), seen(4.9))


@pytest.mark.parametrize("film_s", [2.2, 4.9, 6.1])
def test_a_film_that_ends_amid_motion_shows_no_stop(film_s: float) -> None:
    assert not checked(seen(np.inf, film_s))


def test_the_last_pause_is_no_stop() -> None:
    assert not checked(seen(np.inf, CYCLES * (CYCLE_S + PAUSE_S) + 8.0))
