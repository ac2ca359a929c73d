"""A film's clock that is wrong is told from what servos do: cycles come later and later."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rehearsal import serpenoid_table, snake
from serpenoid.diagnose.data.recordings.clocks import Clock
from serpenoid.diagnose.data.recordings.played import at_played_rate, lateness
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.measure.schedule import Schedule

NOISE, LATE_S = 0.01, 0.05


def played(
    rate: float, seed: int, cycles: int = 3, late_s: float = LATE_S, cycle_s: float = 3.0, hertz: float = 50.0
) -> Recording:
    """Joints that cameras read, all late alike; one is stuck."""
    body, schedule = snake().body, Schedule(serpenoid_table(40), cycle_s, cycles, 1.0)
    time = np.arange(-0.5, cycles * (cycle_s + 1.0) * (1 + rate) + 0.5, 1 / hertz)
    read = schedule.commanded(time / (1 + rate) - late_s)
    read[:, 3] = 0.2
    read += NOISE * np.random.default_rng(seed).normal(size=read.shape)
    markers, clock = np.zeros((len(time), body.vertices, 2)), Clock(0.0, 0.0, 0.0, 0.0)
    return Recording("a", "g", body, schedule, time, markers, time, read, clock, 0.1 * cycle_s, by_servos=False)


@pytest.mark.parametrize("rate", [-0.01, 0.01, 0.03])
@pytest.mark.parametrize("hertz", [20.0, 100.0])
def test_a_schedule_is_as_long_as_the_film_shows_it(rate: float, hertz: float) -> None:
    """Known to the noise of the joints over the speed of the fastest: a hundredth of a per cent."""
    recordings = [played(rate, seed, hertz=hertz) for seed in range(2)]
    for r in at_played_rate(recordings):
        assert r.schedule.cycle_duration_s == pytest.approx(3.0 * (1 + rate), rel=1e-3)
        assert r.schedule.pause_s == pytest.approx(1.0 * (1 + rate), rel=1e-3)
        assert not r.start_said
        assert np.abs(lateness(r)).max() < 0.01  # t0 is where it is read
        assert "on the film's clock" in r.remarks[-1].words
        assert ("more seconds" if rate < 0 else "fewer seconds") in r.remarks[-1].words


def test_what_is_late_alike_in_every_cycle_is_no_rate() -> None:
    recordings = tuple(played(0.0, seed) for seed in range(2))
    assert at_played_rate(recordings) == recordings


def test_a_rate_that_chance_makes_is_none() -> None:
    """At the stated error of 1 %, and only where it is seen among the noise."""
    told = [at_played_rate([played(0.0, 2 * n), played(0.0, 2 * n + 1)])[0].remarks for n in range(40)]
    assert not any(told)


def test_one_cycle_tells_no_rate_and_labels_tell_when_rows_were_due() -> None:
    once, labelled = played(0.01, 0, cycles=1), replace(played(0.01, 1), t0_spread=0.01)
    assert at_played_rate([once]) == (once,)
    assert at_played_rate([labelled]) == (labelled,)


def test_a_log_that_agrees_with_the_table_says_that_the_film_is_wrong() -> None:
    film = replace(played(-0.01, 0), by_servos=True, clock=Clock(0.0, 0.0101, 1e-3, 1e-5))
    (found,) = at_played_rate([replace(film, log_time=film.time * 1.0101)])
    assert "so the film's is wrong" in found.remarks[-1].words


def test_one_clock_is_told_once_whatever_cycles_last() -> None:
    recordings = [replace(played(0.02, n, cycle_s=duration), name=str(n)) for n, duration in enumerate((3.0, 4.0, 5.0))]
    found = at_played_rate(recordings)
    assert len({r.remarks[-1].words for r in found}) == 1
    assert "3.06, 4.08, 5.1 s on the film's clock" in found[0].remarks[-1].words
