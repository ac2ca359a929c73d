"""Protocols drawn at random: within their ranges, repeatable, and played by the same physics as the usual one."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from blind import random_protocols as drawn
from blind.campaign import make
from blind.catalogue import CATALOGUE, Effect
from blind.folder import write
from blind.gaits import progress
from blind.kinds import case
from blind.protocol import Protocol
from blind.snake import SPEED_LIMIT
from blind.strength import floor, strength

SEEDS = range(12)


@pytest.fixture(scope="module")
def protocols() -> list[Protocol]:
    return [drawn.draw_protocol(seed) for seed in SEEDS]


def test_protocols_stay_within_their_ranges(protocols: list[Protocol]) -> None:
    for p in protocols:
        tools = p.instruments
        assert drawn.JOINTS[0] <= p.robot.joints <= drawn.JOINTS[1]
        assert drawn.EPS[0] <= p.eps <= drawn.EPS[1]
        assert drawn.FRAMES[0] <= tools.frames_per_second <= drawn.FRAMES[1]
        assert drawn.NOISE_M[0] <= tools.marker_noise <= drawn.NOISE_M[1]
        assert tools.log_hertz == 0 or drawn.LOG_HERTZ[0] <= tools.log_hertz <= drawn.LOG_HERTZ[1]
        assert len(p.settings) * p.plays <= drawn.MOST_TRIALS
        for s in p.settings:
            table = s.plan.table
            assert np.abs(table).max() <= p.robot.joint_limit + 1e-6
            assert np.abs(np.diff(table, axis=0)).max() * len(table) / s.plan.cycle_s <= SPEED_LIMIT


def test_protocols_differ_and_repeat(protocols: list[Protocol]) -> None:
    assert len({p.robot.joints for p in protocols}) > 3
    assert {p.plays for p in protocols} >= {1, 2}
    assert {bool(p.instruments.log_hertz) for p in protocols} == {True, False}
    again = drawn.draw_protocol(SEEDS[3])
    np.testing.assert_array_equal(again.robot.edges, protocols[3].robot.edges)
    np.testing.assert_array_equal(again.settings[0].plan.table, protocols[3].settings[0].plan.table)


def test_gaits_get_somewhere(protocols: list[Protocol]) -> None:
    far = [abs(progress(s.plan.table, p.eps, p.robot)) for p in protocols for s in p.settings]
    assert np.median(far) > drawn.LEAST_PROGRESS


def test_the_folder_says_what_was_recorded_and_by_what(protocols: list[Protocol], tmp_path: Path) -> None:
    without = next(p for p in protocols if not p.instruments.log_hertz)
    write(make(3, 0, protocol=without), tmp_path)
    campaign = tomllib.loads((tmp_path / "campaign.toml").read_text())
    assert campaign["body"]["vertices"] == without.robot.vertices
    assert campaign["motion"]["frames_per_second"] == without.instruments.frames_per_second
    assert not any("servo_log" in t for t in campaign["trial"])
    header = (tmp_path / campaign["trial"][0]["motion"]).read_text().splitlines()[0]
    assert header.count("x_") == without.robot.vertices


def test_strengths_do_not_depend_on_the_robots_size() -> None:
    """A lag is seen by the servos alone; a slope that grows with the robot leaves the same path in body lengths."""
    c = case("random", 1, 5, "c").campaign
    assert set(drawn.effects_that_show(c.protocol)) <= set(CATALOGUE)
    assert strength(c, Effect("toe", None, {"angle": 0.0}), floor(c)) < 0.05


def test_rows_jump_only_where_the_servos_take_time(protocols: list[Protocol]) -> None:
    held = next(p for p in protocols if p.held)
    lagging = make(3, [Effect("servo_lag", None, {"lag": 0.05})], protocol=held)
    assert all(t.setting.plan.held for t in lagging.trials)
    assert not any(t.setting.plan.held for t in make(3, 0, protocol=held).trials)
