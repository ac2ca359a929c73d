"""What the faults of servos and logs do is what their names say, to one joint, equally in every trial."""

from __future__ import annotations

import numpy as np
import pytest

from blind.bends import BENDS, UNREAD
from blind.cameras import ServoLog
from blind.catalogue import Effect
from blind.faults import servo_fault
from blind.log_faults import MISWRITES
from blind.score import Name
from blind.servo_faults import Said, outcome

TIME = np.linspace(0, 6, 1201)
ANGLES = np.column_stack([np.sin(2 * np.pi * TIME / 3 + lag) for lag in (0.3, 1.5, 2.6)])
JOINT, SEED = 1, 5
LATE = np.arange(len(TIME)) > len(TIME) // 2


def bent(name: str, trial: int = 2) -> tuple[np.ndarray, np.ndarray]:
    return servo_fault(name, JOINT, SEED)(trial, TIME, ANGLES, ANGLES)


@pytest.mark.parametrize("name", [*BENDS, *UNREAD])
def test_a_servo_fault_is_at_its_joint_alone_and_alike_in_trials_that_have_it(name: str) -> None:
    true, _ = bent(name)
    assert np.abs(true - ANGLES)[:, JOINT].max() > 0.05  # rad: many ticks
    np.testing.assert_array_equal(np.delete(true, JOINT, axis=1), np.delete(ANGLES, JOINT, axis=1))
    np.testing.assert_array_equal(bent(name, 4)[0], true)


@pytest.mark.parametrize("name", [*BENDS, *UNREAD])
def test_servos_read_what_they_do_but_where_the_horn_slips_unread(name: str) -> None:
    true, reading = bent(name)
    np.testing.assert_array_equal(reading, ANGLES if name in UNREAD else true)


def test_a_clipped_servo_stays_between_two_stops_and_is_free_between_them() -> None:
    true, own = bent("clipped")[0][:, JOINT], ANGLES[:, JOINT]
    free = true == own
    assert np.ptp(true) < 0.8 * np.ptp(own)
    assert 0.1 < free.mean() < 0.9
    assert len(np.unique(true[~free])) == 2


def test_a_servo_that_dies_half_way_follows_before_and_stays_after() -> None:
    true = bent("dies_half_way")[0][:, JOINT]
    np.testing.assert_array_equal(true[~LATE], ANGLES[~LATE, JOINT])
    assert np.ptp(true[LATE]) == 0.0


def test_a_servo_dead_every_other_trial_stays_in_one_and_follows_in_the_next() -> None:
    assert np.ptp(bent("dead_every_other_trial", 2)[0][:, JOINT]) == 0.0
    np.testing.assert_array_equal(bent("dead_every_other_trial", 3)[0], ANGLES)


def test_a_joint_slow_in_proportion_never_turns_faster_than_a_part_of_what_it_is_told() -> None:
    speed = np.abs(np.gradient(bent("slow_in_proportion")[0][:, JOINT], TIME)).max()
    assert speed < 0.6 * np.abs(np.gradient(ANGLES[:, JOINT], TIME)).max()


def test_a_joint_slow_one_way_is_as_told_on_its_way_back() -> None:
    true, told = bent("slow_one_way")[0][:, JOINT], ANGLES[:, JOINT]
    up, down = np.diff(true), np.diff(told)
    assert up.max() < 0.7 * down.max()
    assert (true <= told).all()
    assert up.min() < 0.9 * down.min()


def test_a_zero_that_slips_once_is_right_in_the_first_trials() -> None:
    np.testing.assert_array_equal(bent("zero_slips_once", 1)[0], ANGLES)
    assert np.ptp(bent("zero_slips_once", 2)[0][:, JOINT] - ANGLES[:, JOINT]) < 1e-12


def test_a_joint_that_sticks_stands_still_most_of_the_time() -> None:
    speed = np.abs(np.gradient(bent("sticks_and_slips")[0][:, JOINT], TIME))
    assert np.median(speed) < 0.2 * np.median(np.abs(np.gradient(ANGLES[:, JOINT], TIME)))


@pytest.fixture
def log() -> ServoLog:
    rows = np.arange(len(TIME))
    return ServoLog(TIME, rows // 600, rows % 600, np.full(len(rows), "play"), ANGLES, ANGLES)


@pytest.mark.parametrize("name", MISWRITES)
def test_a_log_fault_leaves_commands_as_they_were_given(name: str, log: ServoLog) -> None:
    found = MISWRITES[name](np.random.default_rng(SEED), log, JOINT)
    kept = np.isin(log.time, found.time) if len(found.time) < len(log.time) else slice(None)
    np.testing.assert_array_equal(found.command, log.command[kept])
    changed = np.abs(found.position - log.position[kept]).max() > 0
    assert changed != (name in ("log_with_lost_rows", "log_of_another_clock"))


def test_a_late_reading_is_what_was_so_long_ago(log: ServoLog) -> None:
    found = MISWRITES["log_late"](np.random.default_rng(SEED), log, JOINT)
    np.testing.assert_allclose(found.position[30:, JOINT], log.position[:-30, JOINT], atol=1e-12)  # 30 rows: 0.15 s


def test_outcomes_tell_a_right_name_a_wrong_one_words_and_silence_apart() -> None:
    truth, play = [Effect("backlash", 2, {"width": 0.05})], Name("backlash", 2)
    assert outcome("backlash", truth, Said(named=(play,))) == "right"
    assert outcome("backlash", truth, Said(named=(Name("backlash", 3),))) == "wrong name"
    assert outcome("backlash", truth, Said()) == "no name"
    assert outcome("clipped", [], Said(named=(play,), told=("words",))) == "wrong name"
    assert outcome("clipped", [], Said(named=(play,), stand_ins=(play,))) == "stand-in"
    assert outcome("clipped", [], Said(told=("words",))) == "refused in words"
    assert outcome("backlash", truth, Said(), strength=1.0) == "below detection"
    assert outcome("slow_one_way", [], Said(named=(Name("slow_joint", 2),)), 2) == "akin"
    assert outcome("slow_one_way", [], Said(named=(Name("slow_joint", 1),)), 2) == "wrong name"
    assert outcome("nothing", [], Said()) == "right"
    assert outcome("nothing", [], Said(crash="Traceback")) == "crash"
