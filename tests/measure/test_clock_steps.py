"""A log whose own clock steps is told from rows that were lost, and from a robot that stood still."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from serpenoid.measure.consistency.check import check
from serpenoid.measure.consistency.claim import Claim
from serpenoid.measure.consistency.clock_steps import UNTOLD, far_steps
from serpenoid.measure.consistency.signals import Signal
from serpenoid.measure.schedule import Schedule

PHASE = 2 * np.pi * np.arange(40)[:, None] / 40 - 1.2 * np.arange(5)
ROWS = 0.5 * np.cos(PHASE) + 0.15 * np.cos(2 * PHASE) + 0.1
SCHEDULE = Schedule(ROWS, 3.0, 2, 0.5)
TIME = np.arange(-0.5, SCHEDULE.end_s + 0.5, 1 / 50)


def recorded(commands: bool, films: bool, filmed: np.ndarray = TIME) -> Claim:
    """A healthy trial; filmed: when the robot was where the schedule has it at TIME."""
    rng, told = np.random.default_rng(3), SCHEDULE.commanded(TIME)
    read, seen = told + rng.normal(0, 0.001, told.shape), told + rng.normal(0, 0.005, told.shape)
    film = Signal(filmed + 7, seen) if films else None
    return Claim("t", "gait", SCHEDULE, film, Signal(TIME, read), Signal(TIME, told) if commands else None)


EARLY, LATE, LAST = (1.7, 0.5), (1.7, 2.5), (4.6, 0.5)
ALWAYS = [(True, True, EARLY), (True, False, LATE), (True, True, LAST), (False, False, EARLY)]


def stepped(claim: Claim, at_s: float, seconds: float) -> Claim:
    """The same with a log whose clock steps."""

    def late(signal: Signal | None) -> Signal | None:
        return None if signal is None else Signal(signal.time_s + seconds * (signal.time_s >= at_s), signal.values)

    return replace(claim, servos=late(claim.servos), commands=late(claim.commands))


@pytest.mark.parametrize(
    ("at_s", "seconds", "films", "commands"),
    [
        pytest.param(*step, films, commands, marks=[] if (films, commands, step) in ALWAYS else pytest.mark.slow)
        for step in (EARLY, LATE, LAST)
        for films in (True, False)
        for commands in (True, False)
    ],
)
def test_a_step_of_the_logs_clock_is_told_with_its_place(commands, films, at_s, seconds):
    (found,) = check([stepped(recorded(commands, films), at_s, seconds)], {"gait": ROWS}).contradictions
    assert found.kind == "clock"
    cure = f"did the log's clock jump? Take {seconds:g} s off its times from {at_s + seconds:g} s on"
    assert found.cure == cure + ("" if films else UNTOLD)


@pytest.mark.parametrize("commands", [True, False])
def test_rows_that_were_lost_are_no_step(commands):
    claim = recorded(commands, films=True)
    kept = (TIME < 1.7) | (TIME > 2.6)

    def some(signal: Signal | None) -> Signal | None:
        return None if signal is None else Signal(signal.time_s[kept], signal.values[kept])

    claim = replace(claim, servos=some(claim.servos), commands=some(claim.commands))
    assert far_steps(TIME[kept])
    assert check([claim], {"gait": ROWS}).contradictions == ()


def test_a_robot_that_stood_still_is_not_a_step_of_its_logs_clock():
    """The film saw it stand, so the log's clock is right."""
    stood = TIME + 0.5 * (TIME >= 1.7)
    verdict = check([stepped(recorded(True, True, stood), 1.7, 0.5)], {"gait": ROWS})
    assert "clock" not in [one.kind for one in verdict.contradictions]
