"""Two clocks laid over each other: readings of a slow log beside a fast film."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.body import Body
from serpenoid.diagnose.data.recordings.clocks import Clock, align, beside_plan, run_apart
from serpenoid.diagnose.data.recordings.laid import Plan
from serpenoid.errors import InputError
from serpenoid.measure.logs import TICK, ServoLog
from serpenoid.measure.shapes.links import chain_vertices

FRAMES_PER_SECOND, LOG_HERTZ, MARKER_M, SECONDS, CYCLE_S = 200.0, 14.0, 1.5e-4, 6.0, 2.5
DRAWS = 12


def bent(time: np.ndarray, joints: int) -> np.ndarray:
    """Two waves; at rest before and after."""
    phase = 2 * np.pi * np.clip(time, 0, 2 * CYCLE_S)[:, None] / CYCLE_S + np.arange(joints)
    return 0.5 * np.sin(phase) + 0.15 * np.sin(2 * phase)


def test_a_slow_log_beside_a_fast_film_has_no_other_rate_than_its_deviation_says() -> None:
    """Straight lines between readings cut off the bends, and a reading's error lasts for all frames beside it: rates
    of clocks that run alike were 4 to 9 deviations."""
    body = Body(vertices=6, edge_lengths=(0.1,) * 5)
    far = []
    for draw in range(DRAWS):
        rng = np.random.default_rng(draw)
        film = np.arange(-0.5, SECONDS, 1 / FRAMES_PER_SECOND)
        markers = chain_vertices(body, np.zeros((len(film), 3)), bent(film, body.joint_count))
        markers = markers + rng.normal(0, MARKER_M, markers.shape)
        time = np.arange(-0.6, SECONDS + 0.2, 1 / LOG_HERTZ) + rng.uniform(0, 0.01)
        read = np.round((bent(time, body.joint_count) + rng.normal(0, 0.4 * TICK, (len(time), 4))) / TICK) * TICK
        clock = align(body, film, markers, ServoLog(time, read, None, None, None, None, {}, "log.csv"))
        far.append(clock.rate / clock.rate_sd)
    assert 0.3 < np.sqrt(np.mean(np.square(far))) < 1.7  # chi squared of twelve, beyond 1 in 1000


def one_cycle(time: np.ndarray, cycle_s: float = CYCLE_S) -> np.ndarray:
    """A plan that begins and ends amid its motion, as rows on straight lines do."""
    phase = 2 * np.pi * np.clip(time, 0, cycle_s)[:, None] / cycle_s + 0.7 * np.arange(5)
    return 0.5 * np.sin(phase) + 0.15 * np.sin(2 * phase) - 0.1


def told_by_plan(
    draw: int,
    hertz: float,
    beside: tuple[float, float] = (0.0, 0.0),
    rate: float = 0.0,
    noise_m: float = 5e-4,
    plan: Plan | None = one_cycle,
) -> Clock:
    """A film of a healthy robot, or with a marker of vertex 5 beside its place on the link ahead, and its log."""
    body, rng = Body(vertices=7, edge_lengths=(0.08,) * 6), np.random.default_rng(draw)
    film = np.arange(-1.0, CYCLE_S + 2.0, 1 / 60)
    markers = chain_vertices(body, np.zeros((len(film), 3)), one_cycle((1 + rate) * film))
    ahead = (markers[:, 6] - markers[:, 5]) / 0.08
    across = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
    markers[:, 5] += beside[0] * ahead + beside[1] * across
    markers += rng.normal(0, noise_m, markers.shape)
    time = np.arange(-1.0, CYCLE_S + 2.0, 1 / hertz) + rng.uniform(0, 1 / hertz)
    read = np.round((one_cycle(time) + rng.normal(0, 0.4 * TICK, (len(time), 5))) / TICK) * TICK
    log = ServoLog(time, read, None, None, None, None, {}, "log.csv")
    return beside_plan(align(body, film, markers, log), body, film, markers, log, plan)


def test_where_motion_begins_between_the_rows_of_a_slow_log_the_plan_says() -> None:
    """Cubics between rows begin to move before they should and end late: another rate in every trial."""
    clocks = [told_by_plan(draw, 5.0, noise_m=1e-4) for draw in range(DRAWS)]
    assert np.sqrt(np.mean([(clock.rate / clock.rate_sd) ** 2 for clock in clocks])) < 1.7


def test_a_displaced_marker_is_no_rate_and_a_rate_is_one() -> None:
    """In the rate that shall convict a film's clock; that of all that is seen is known better, but for the marker."""
    far, told = [], []
    for draw in range(DRAWS):
        displaced = told_by_plan(draw, 50.0, (-8e-3, 8e-3))
        wrong = told_by_plan(draw, 50.0, rate=0.02)
        assert displaced.apart is not None
        assert wrong.apart is not None
        far.append(displaced.apart[0] / displaced.apart[1])
        told.append((wrong.apart[0] - 0.02) / wrong.apart[1])
        assert wrong.apart[0] > 5 * wrong.apart[1]
    for deviations in (far, told):
        assert abs(np.mean(deviations)) < 3 / np.sqrt(DRAWS)
        assert np.sqrt(np.mean(np.square(deviations))) < 1.7


def test_without_a_plan_a_displaced_marker_is_no_rate_either() -> None:
    """Rows that jump: what servos do between them is not the plan's, so the clock stays."""
    far = []
    for draw in range(DRAWS):
        apart = told_by_plan(draw, 50.0, (-8e-3, 8e-3), plan=None).apart
        assert apart is not None
        far.append(apart[0] / apart[1])
    assert abs(np.mean(far)) < 3 / np.sqrt(DRAWS)


def test_a_film_that_seldom_shows_all_markers_is_said_to(monkeypatch: pytest.MonkeyPatch) -> None:
    body, rng = Body(vertices=6, edge_lengths=(0.1,) * 5), np.random.default_rng(1)
    film = np.arange(0, 4.0, 1 / 20)
    markers = chain_vertices(body, np.zeros((len(film), 3)), bent(film, body.joint_count))
    hidden = np.flatnonzero(np.arange(len(film)) % 8)
    markers[hidden, rng.integers(0, 6, len(hidden))] = np.nan
    log = ServoLog(film, bent(film, body.joint_count), None, None, None, None, {}, "log.csv")
    assert align(body, film, markers, log).zero == pytest.approx(0.0, abs=0.01)  # ten frames do
    monkeypatch.setattr("serpenoid.diagnose.data.recordings.clocks.find_offset", lambda *_: None)
    with pytest.raises(InputError, match=r"in 72% of its frames enough markers are seen"):
        align(body, film, markers, log)


def test_a_log_is_laid_over_a_film_that_hides_a_marker_whenever_the_robot_moves() -> None:
    """Of 17 markers each hidden for a tenth of the frames one is hidden in five of six; here in all that move."""
    body, rng = Body(vertices=10, edge_lengths=(0.06,) * 9), np.random.default_rng(4)
    film = np.arange(-0.5, SECONDS, 1 / 60)
    angles = bent(film, body.joint_count)
    markers = chain_vertices(body, np.zeros((len(film), 3)), angles) + rng.normal(0, MARKER_M, (len(film), 10, 2))
    moving = np.flatnonzero((film > 0) & (film < 2 * CYCLE_S))
    for part in np.array_split(moving, 30):  # for a sixth of a second another marker
        markers[part, rng.integers(10)] = np.nan
    time = np.arange(-0.6, SECONDS + 0.2, 1 / LOG_HERTZ)
    log = ServoLog(time + 3.0, bent(time, body.joint_count), None, None, None, None, {}, "log.csv")
    clock = align(body, film, markers, log)
    assert clock.zero == pytest.approx(3.0, abs=2e-3)


def test_rates_that_differ_by_chance_or_by_what_a_displaced_marker_makes_are_one() -> None:
    draws, sd = np.random.default_rng(3).normal(size=(200, 6)), 5e-5
    assert not any(_apart([Clock(0.0, 1e-3 + sd * x, 0.0, sd) for x in draw]) for draw in draws)
    drawn_aside = [Clock(0.0, x, 0.0, sd, apart=(0.0, 2 * sd)) for x in (0.0, 0.0, 2e-3)]  # one gait bends beside it
    assert not _apart(drawn_aside)
    assert _apart([Clock(0.0, x, 0.0, sd, apart=(x, 2 * sd)) for x in (0.0, 0.0, 2e-3)])
    assert not _apart([Clock(0.0, 2e-3, 0.0, sd)])


def _apart(clocks: list[Clock]) -> bool:
    """Of trials of a gait each."""
    return run_apart(clocks, [(f"gait {n}", 4.0) for n in range(len(clocks))])


@pytest.mark.parametrize(
    ("rates", "order", "apart"),
    [
        ((0.0, 0.0, 2e-3, 0.0, 0.0, 2e-3), "abcabc", False),  # whenever gait c is played
        ((0.0, 0.0, 2e-3, 0.0, 0.0, 0.0), "abcabc", True),  # once
        ((0.0, 0.0, 0.0, 2e-3, 2e-3, 2e-3), "abcabc", True),  # a camera that was started anew between the rounds
        ((0.0, 0.0, 2e-3, 2e-3, 0.0, 0.0), "aabbcc", True),  # gait by gait: it may be either
        ((0.0, 0.0, 0.0, 2e-3), "abab", True),
        ((0.0, 2e-3, 0.0), "aba", False),  # of b alone, with a before and after: no other clock between the two
    ],
)
def test_a_rate_that_comes_with_a_gait_is_no_clock_s(rates: tuple[float, ...], order: str, apart: bool) -> None:
    clocks = [Clock(0.0, rate, 0.0, 1e-4) for rate in rates]
    assert run_apart(clocks, [(gait, 4.0) for gait in order]) is apart
