"""The checker: every refusal names joint, step, value, limit and remedy; a good gait passes."""

from math import radians

import numpy as np
import pytest
from emulated import ROBOT_FILE, XL430, gait, robot, serpenoid, write_gait

from serpenoid.errors import InputError
from serpenoid.files.schema import read_toml, validate
from serpenoid.robot.checks import check_body, check_start, check_table, check_voltage
from serpenoid.robot.description import Robot
from serpenoid.robot.plan import row_speeds_rpm
from serpenoid.robot.stated import Stated
from serpenoid.robot.table import write_table
from serpenoid.robot.ticks import to_ticks


def says(refusal, *parts):
    sentence = str(refusal)
    for part in parts:
        assert part in sentence


def test_good_gait_passes():
    assert check_table(gait(50, 0.6), robot(), 5.0, 11.1) == []


def test_position_outside_the_limits():
    angles = gait()
    angles[7, 3] = radians(85.0)
    (refusal,) = check_table(angles, robot(), 60.0, 11.1)
    says(refusal, "joint_4 (ID 4), step 7", "85.0 degrees (3015 ticks)", "-80.0..80.0 degrees (1138..2958 ticks)")
    says(refusal, "1 step outside", "reduce the amplitude")


def test_limits_follow_the_sign():
    data = read_toml(ROBOT_FILE)
    data["joint"][3].update(sign=-1, maximum_ticks=2148)
    angles = gait()
    angles[7, 3] = -0.5
    (refusal,) = check_table(angles, validate(Robot, data, "t"), 60.0, 11.1)
    says(refusal, "joint_4 (ID 4), step 7", "2374 ticks", "1138..2148 ticks")


def test_speed_above_the_joint_limit_and_its_remedy_suffices():
    angles = gait(50, 1.0)
    refusals = check_table(angles, robot(), 1.2, 12.0)
    assert len(refusals) == 10
    says(refusals[0], "joint_1 (ID 1), step 0", "rpm in a cycle of 1.2 s", "the limit is 40.0 rpm (`speed_limit_rpm`)")
    needed = float(str(refusals[0]).split("a cycle of ")[-1].split(" s or more")[0])
    assert check_table(angles, robot(), needed, 12.0) == []
    assert check_table(angles, robot(), needed - 0.05, 12.0) != []


def test_speed_above_no_load_speed_at_a_low_voltage():
    data = read_toml(ROBOT_FILE)
    for joint in data["joint"]:
        joint["speed_limit_rpm"] = 60.0
    fast = validate(Robot, data, "t")
    angles = gait(50, 1.0)
    assert check_table(angles, fast, 1.15, 12.0) == []  # 52 rpm at the most, 61 rpm can be had
    refusals = check_table(angles, fast, 1.15, 9.0)
    says(refusals[0], "joint_1", "step", "the limit is 45.8 rpm (no-load speed at 9.0 V)", "Play it slower")


def test_a_servo_that_cannot_move_at_all_is_refused_with_words():
    """A supply so low that its no-load speed is zero: no cycle is slow enough."""
    refusals = check_table(gait(40, 0.5), robot(), 5.0, 0.0)
    assert refusals
    assert all("cannot move at all" in refusal.remedy for refusal in refusals)


def test_no_load_speed_is_at_or_just_below_the_published_values():
    # ROBOTIS e-manual, XL430-W250: 47 rpm at 9.0 V, 57 at 11.1 V, 61 at 12.0 V; the line may be 3 % too careful
    for voltage, published in ((9.0, 47.0), (11.1, 57.0), (12.0, 61.0)):
        assert 0.97 * published <= XL430.no_load_speed_rpm(voltage) <= published


def test_table_that_does_not_close():
    angles = np.linspace(0.0, 0.5, 50)[:, None] * np.ones(10)
    refusals = check_table(angles, robot(), 1.0, 11.1)
    says(refusals[0], "joint_1 (ID 1), step 49", "jump of 28.", "from the last row to the first", "does not close")


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_values_that_are_not_finite(bad):
    angles = gait()
    angles[5, 2] = bad
    (refusal,) = check_table(angles, robot(), 5.0, 11.1)
    says(refusal, "joint_3, step 5", str(bad), "must be finite", "Solve or export the gait again")


@pytest.mark.parametrize("angles", [gait(20, 0.1, joints=9), gait(20, 0.1)[:1], np.zeros(10)])
def test_wrong_shape(angles):
    (refusal,) = check_table(angles, robot(), 5.0, 11.1)
    says(refusal, "all joints, all steps", "steps x joints", "10 joints and needs at least 2 steps", "Use a table")


def test_a_table_of_more_joints_than_the_robot_has_says_what_to_do_of_dead_servos():
    (refusal,) = check_table(gait(joints=12), robot(), 5.0, 11.1)
    says(refusal, "20 x 12", "without its dead servos: a body whose `joints` leave them out")


def test_bus_too_slow_for_the_rows():
    data = read_toml(ROBOT_FILE)
    data["bus"]["baud_rate"] = 57600
    (refusal,) = check_table(gait(50), validate(Robot, data, "t"), 2.0, 11.1)
    says(refusal, "all joints, every step", "57600 baud", "a row lasts 40.0 ms", "raise the baud rate")
    assert check_table(gait(50), validate(Robot, data, "t"), 5.0, 11.1) == []


def test_start_too_far_and_start_outside_the_limits():
    present = np.full(10, 2048)
    present[4], present[8] = 1200, 3500
    far, outside = check_start(present, np.full(10, 2400), robot())
    says(far, "joint_5 (ID 5), step 0", "105.5 degrees away", "90 degrees", "by hand")
    says(outside, "joint_9 (ID 9), step 0", "3500 ticks", "1138..2958", "turn the joint by hand")


def test_voltage_outside_the_window():
    volts = np.full(10, 11.1)
    volts[2], volts[5] = 9.5, 13.0
    low, high = check_voltage(volts, robot())
    says(low, "joint_3 (ID 3)", "9.5 V", "9.9..12.6 V", "Charge the battery")
    says(high, "joint_6 (ID 6)", "13.0 V", "right supply")


def test_check_command_refuses_with_exit_code_1_and_passes_with_0(tmp_path):
    bad = gait()
    bad[3, 0] = 2.0
    write_table(tmp_path / "bad.csv", bad)
    done = serpenoid("robot", "check", tmp_path / "bad.csv", "--robot", ROBOT_FILE)
    assert done.returncode == 1
    assert "joint_1 (ID 1), step 3" in done.stderr
    assert serpenoid("robot", "check", write_gait(tmp_path), "--robot", ROBOT_FILE).returncode == 0


@pytest.mark.parametrize(
    ("change", "place"),
    [
        ({"speed_limit_rpm": 100.0}, r"\[\[joint\]\] 3 speed_limit_rpm: "),
        ({"zero_ticks": 0}, r"\[\[joint\]\] 3: `minimum_ticks` < `zero_ticks`"),
    ],
)
def test_a_fault_of_joint_3_in_a_robot_file_is_one_of_its_third_joint(change: dict[str, float], place: str) -> None:
    data = robot().model_dump()
    data["joint"][2] |= change
    with pytest.raises(InputError, match=place):
        validate(Robot, data, "robot.toml")


@pytest.mark.parametrize("closed", [False, True])
def test_a_transient_has_no_step_back_to_its_first_row(closed):
    """0.5 rad in 10 even steps and 0.8 s, 6 rpm; as a closed table it jumps back in an eleventh."""
    angles = np.linspace(0, 0.5, 11)[:, None] * np.ones(10)
    speeds = row_speeds_rpm(to_ticks(angles, robot()), robot(), 0.8, closed)
    assert speeds.shape == (11 if closed else 10, 10)
    # a step of 33 ticks is off by a tick at most
    assert speeds.max() == pytest.approx(60 * 0.5 / (2 * np.pi) / 0.8 * (11 if closed else 1), rel=1 / 33)
    refusals = check_table(angles, robot(), 0.8, 11.1, closed)
    assert bool(refusals) == closed


def test_the_bodys_speed_limit_holds_for_the_steps_of_a_transient_alone():
    angles = np.linspace(0, 0.5, 11)[:, None] * np.ones(10)
    limits = {"body": {"joint_speed_limit_rpm": 7.0}}  # 60 * 0.5 / (2 pi) / 0.8 = 5.97 rpm
    assert check_body(angles, Stated.model_validate(limits | {"transient": True}), 0.8) == []
    (refusal,) = check_body(angles, Stated.model_validate(limits), 0.8)
    assert "speed 65.7 rpm" in refusal.value
    (refusal,) = check_body(angles, Stated.model_validate(limits | {"transient": True}), 0.6)
    assert "a cycle of 0.69 s or more" in str(refusal)
