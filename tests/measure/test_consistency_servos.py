"""Servos that are late or slow stretch what is recorded: no fault of the file; a wrong duration is one all the same."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.measure.consistency.check import Verdict, check
from serpenoid.measure.consistency.claim import Claim
from serpenoid.measure.consistency.signals import Signal
from serpenoid.measure.schedule import Schedule


def table(joints: int) -> np.ndarray:
    """A travelling wave about a bend: the body begins and ends at rest in it, away from its mean."""
    return 0.35 + 0.6 * np.sin(2 * np.pi * (np.arange(40)[:, None] / 40 + np.arange(joints) / joints + 0.5))


def late(time: np.ndarray, told: np.ndarray) -> np.ndarray:
    """Explicit steps of q' = (told - q) / 0.25 s."""
    return followed(time, told, lambda gap, step: gap * step / 0.25)


def slow(time: np.ndarray, told: np.ndarray) -> np.ndarray:
    """No joint turns faster than a third of what the quickest is told."""
    reach = np.abs(np.diff(told, axis=0)).max() / np.diff(time)[0] / 3
    return followed(time, told, lambda gap, step: np.clip(gap, -reach * step, reach * step))


def followed(time, told, move) -> np.ndarray:
    done = told.copy()
    for row in range(1, len(time)):
        done[row] = done[row - 1] + move(told[row] - done[row - 1], time[row] - time[row - 1])
    return done


def as_told(time: np.ndarray, told: np.ndarray) -> np.ndarray:
    return told


def seen(servos, joints: int, promised_s: float, played_s: float = 2.0) -> Verdict:
    """One cycle of a gait by these servos, filmed 50 times a second, and the promise of its duration."""
    rows = table(joints)
    time = np.arange(-1.0, played_s + 2.0, 1 / 500)
    angles = servos(time, Schedule(rows, played_s, 1, 0.0).commanded(np.clip(time, 0.0, played_s)))[::10]
    angles += 0.003 * np.random.default_rng(joints).standard_normal(angles.shape)
    claim = Claim("one", "gait", Schedule(rows, promised_s, 1, 0.0), cameras=Signal(time[::10], angles))
    return check([claim], {"gait": rows})


@pytest.mark.parametrize("joints", [11, 16])
def test_a_cycle_stretched_by_slow_servos_is_told_and_not_refused(joints):
    verdict = seen(slow, joints, 2.0)
    assert verdict.contradictions == ()
    assert any("servos that are late or slow explain that as well" in said for _, said in verdict.remarks)


def test_late_servos_are_no_contradiction():
    assert seen(late, 11, 2.0).contradictions == ()


WRONG = [*((s, f) for s in (as_told, late) for f in (0.6, 0.8, 1.25, 1.6)), (slow, 0.6), (slow, 1.6)]
ALWAYS = [(as_told, 1.25), (late, 0.8), (late, 1.25), (slow, 0.6), (slow, 1.6)]  # the nearest that each is refused


@pytest.mark.parametrize(
    ("servos", "factor"), [pytest.param(*w, marks=[] if w in ALWAYS else pytest.mark.slow) for w in WRONG]
)
def test_a_wrong_duration_is_refused_all_the_same(servos, factor):
    """Of servos as slow as these it must be further off: slower ones explain what is a little longer."""
    verdict = seen(servos, 8, 2.0 * factor)
    assert [found.kind for found in verdict.contradictions] in (["duration"], ["rate"])


def beside(log_s: float, rows: np.ndarray) -> Verdict:
    """Three cycles of 4 s with pauses of 1 s on film, and so many seconds of a log of servos that play `rows`."""
    schedule = Schedule(table(8), 4.0, 3, 1.0, start_s=2.0)
    time, at = np.arange(0.0, 17.0, 0.02), np.arange(0.5, 0.5 + log_s, 0.03)
    angles = schedule.commanded(time) + 0.003 * np.random.default_rng(0).standard_normal((len(time), 8))
    servos = Signal(at + 100.0, Schedule(rows, 4.0, 3, 1.0, start_s=2.0).commanded(at))
    return check([Claim("one", "gait", schedule, cameras=Signal(time, angles), servos=servos)], {"gait": table(8)})


@pytest.mark.parametrize("log_s", [6.0, 8.0, 9.0, 11.0, 15.5])
def test_a_servo_log_that_ends_early_is_no_contradiction(log_s):
    assert beside(log_s, table(8)).contradictions == ()


@pytest.mark.parametrize("log_s", [pytest.param(8.0, marks=pytest.mark.slow), 15.5])
def test_another_motion_in_a_servo_log_is_one_all_the_same(log_s):
    other = np.cos(2 * np.pi * (np.arange(40)[:, None] / 40 * 3 + np.random.default_rng(1).uniform(size=8)))
    assert beside(log_s, other).contradictions
