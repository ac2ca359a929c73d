"""The arena behind a bus: ticks in, ticks out, and the robot crawls."""

import numpy as np
import pytest

from arena.support import LENGTH, serpenoid_table
from serpenoid.arena.bench import CENTRE, Bench
from serpenoid.errors import InputError


@pytest.fixture
def bench():
    return Bench()


def test_a_servo_goes_to_its_goal_and_the_others_stay(bench):
    bench.set_goal_ticks(3, CENTRE + 200)
    for _ in range(100):
        bench.step(0.01)
    assert bench.position_ticks(3) == pytest.approx(CENTRE + 200, abs=30)  # friction leaves two degrees or so
    assert bench.position_ticks(7) == pytest.approx(CENTRE, abs=20)
    assert abs(bench.load(3)) < 0.3
    assert bench.voltage(3) == pytest.approx(11.0, abs=0.2)


def test_portions_of_time_add_up(bench):
    for _ in range(1000):
        bench.step(0.0003)
    assert bench.world.time_s == pytest.approx(0.3, abs=1 / 360)


def test_without_torque_a_servo_does_not_move(bench):
    bench.set_torque(5, False)
    bench.set_goal_ticks(5, CENTRE + 400)
    bench.step(0.5)
    assert bench.position_ticks(5) == pytest.approx(CENTRE, abs=2)
    bench.set_torque(5, True)
    bench.step(0.5)
    assert bench.position_ticks(5) > CENTRE + 300


def test_a_gait_given_in_ticks_crawls(bench):
    before = bench.markers()[:, :2].mean(axis=0)
    for row in [*serpenoid_table(), *serpenoid_table()]:
        for joint, angle in enumerate(row, 1):
            bench.set_goal_ticks(joint, CENTRE + angle / (2 * np.pi) * 4096)
        bench.step(0.1)
    assert bench.markers()[:, :2].mean(axis=0)[0] - before[0] > 0.3 * LENGTH


def test_there_are_ten_joints(bench):
    with pytest.raises(InputError, match="`joint` must be 1"):
        bench.set_goal_ticks(0, CENTRE)
