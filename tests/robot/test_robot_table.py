"""Tables, ticks and robot files: round trips and refusals of bad files."""

import json
from math import pi

import numpy as np
import pytest
from emulated import ROBOT_FILE, gait, robot
from hypothesis import given
from hypothesis import strategies as st

from serpenoid.errors import InputError
from serpenoid.files.schema import read_toml, validate
from serpenoid.robot.checks import check_table
from serpenoid.robot.description import Robot
from serpenoid.robot.plan import make_plan
from serpenoid.robot.table import read_table, write_table
from serpenoid.robot.ticks import to_radians, to_ticks

HALF_TICK = pi / 4096


@given(
    angles=st.lists(st.floats(-pi, pi), min_size=10, max_size=10),
    signs=st.lists(st.sampled_from([-1, 1]), min_size=10, max_size=10),
    zeros=st.lists(st.integers(1200, 2900), min_size=10, max_size=10),
)
def test_radians_to_ticks_and_back_within_half_a_tick(angles, signs, zeros):
    data = read_toml(ROBOT_FILE)
    for joint, sign, zero in zip(data["joint"], signs, zeros, strict=True):
        joint.update(sign=sign, zero_ticks=zero)
    mapped = validate(Robot, data, "test")
    back = to_radians(to_ticks(angles, mapped), mapped)
    # half a tick, and the rounding of angles up to pi in double precision
    assert np.abs(back - angles).max() <= HALF_TICK + 1e-12


def test_a_last_line_without_an_end_is_refused_beside_a_record_and_else_a_doubt(tmp_path):
    table = tmp_path / "gait.csv"
    write_table(table, gait())
    assert read_table(table).doubts == ()
    table.write_text(table.read_text().rstrip("\n"))
    with pytest.raises(InputError, match="the last line has no end, and programs that write so many digits end their"):
        read_table(table)
    write_table(table, gait().round(4))
    table.write_text(table.read_text().rstrip("\n"))
    (doubt,) = read_table(table).doubts
    assert "gait.csv: the last line has no end. Was the file cut short within its last number?" in doubt
    (tmp_path / "gait.json").write_text('{"cycle_duration_s": 5.0, "transient": false}')
    with pytest.raises(InputError, match="the last line has no end. .* Write the results again"):
        read_table(table)


@given(ticks=st.lists(st.integers(0, 4095), min_size=10, max_size=10))
def test_ticks_to_radians_and_back_is_exact(ticks):
    assert to_ticks(to_radians(ticks, robot()), robot()).tolist() == ticks


def test_sign_and_zero_turn_the_way_the_robot_file_says():
    data = read_toml(ROBOT_FILE)
    data["joint"][0].update(sign=-1, zero_ticks=2000)
    angles = np.zeros(10)
    angles[0] = pi / 2
    assert to_ticks(angles, validate(Robot, data, "test"))[0] == 2000 - 1024


def test_behind_a_gear_ticks_are_the_servos_and_angles_and_speeds_the_joints():
    data = read_toml(ROBOT_FILE)
    data["joint"][0].update(
        sign=-1, zero_ticks=2000, minimum_ticks=100, maximum_ticks=3900, gear_ratio=2.5, speed_limit_rpm=20
    )
    plain, geared = validate(Robot, read_toml(ROBOT_FILE), "test"), validate(Robot, data, "test")
    angles = np.full((4, 10), 0.5) * np.array([[0], [1], [0], [-1]])
    ticks = to_ticks(angles, geared)
    assert ticks[1, 0] == 2000 - round(2.5 * 0.5 * 4096 / (2 * pi))
    assert (ticks[:, 1:] == to_ticks(angles, plain)[:, 1:]).all()
    assert np.abs(to_radians(ticks, geared) - angles)[:, 0].max() <= HALF_TICK / 2.5 + 1e-12
    low, high = geared.joint[0].angle_range
    assert (low, high) == pytest.approx((-1900 / 2.5 * 2 * pi / 4096, 1900 / 2.5 * 2 * pi / 4096))
    fast = make_plan(angles, geared, 2.0, 1, 0.0)
    assert fast.peak_speed_rpm()[0] == pytest.approx(
        make_plan(angles, plain, 2.0, 1, 0.0).peak_speed_rpm()[0], rel=2e-3
    )
    unit = geared.servos[0].rpm_per_velocity_unit
    assert fast.approach_velocity()[0] == int(2.5 * geared.motion.approach_speed_rpm / unit)
    assert geared.tracking_limits_deg[1] == plain.tracking_limits_deg[1]


def test_a_joint_is_no_faster_than_its_motor_behind_the_gear():
    data = read_toml(ROBOT_FILE)
    data["joint"][0].update(gear_ratio=4.0, speed_limit_rpm=20.0)
    with pytest.raises(
        InputError, match="at most 15.25 rpm, what XL430-W250-T servos do at 12 V .* behind a gear of 4"
    ):
        validate(Robot, data, "test")
    data["joint"][0].update(speed_limit_rpm=15.0)
    angles = np.zeros((8, 10))
    angles[::2, 0] = 0.3
    refused = [str(refusal) for refusal in check_table(angles, validate(Robot, data, "t"), 1.3, 11.1)]
    assert len(refused) == 1
    assert "joint_1 (ID 1), step " in refused[0]
    assert "the limit is 14.1 rpm (no-load speed at 11.1 V)" in refused[0]  # a quarter of the motor's


NOTHING_STATED = {"cycle_duration_s": None, "transient": False, "body": {}, "limits_held": {}}


def test_results_folder_is_read_with_its_cycle_duration(tmp_path):
    write_table(tmp_path / "joint_table.csv", gait())
    (tmp_path / "solution.json").write_text(json.dumps(NOTHING_STATED | {"cycle_duration_s": 4.0}))
    table = read_table(tmp_path)
    assert np.array_equal(table.angles, gait())
    assert table.stated.cycle_duration_s == 4.0


@pytest.mark.parametrize(
    "content",
    [
        "{",
        "[]",
        '{"cycle_duration_s": "5"}',
        '{"cycle_duration_s": -1}',
        '{"cycle_duration_s": 1e999}',
        '{"cycle_duration_s": 700}',
        '{"cycle_duration_s": true}',
        '{"body": {"joint_limit_deg": -50}}',
        '{"limits_held": {"joint_limits": "no"}}',
        "[" * 5000,
    ],
)
def test_a_broken_solution_is_refused_rather_than_replaced_by_the_robot_files_duration(tmp_path, content):
    write_table(tmp_path / "joint_table.csv", gait())
    (tmp_path / "solution.json").write_text(content)
    with pytest.raises(InputError, match=r"solution\.json: .*Write the results again"):
        read_table(tmp_path)


def test_a_solution_that_states_no_duration_leaves_it_to_the_robot_file(tmp_path):
    write_table(tmp_path / "joint_table.csv", gait())
    (tmp_path / "solution.json").write_text(json.dumps(NOTHING_STATED | {"kkt": 5}))
    assert read_table(tmp_path).stated.cycle_duration_s is None


@pytest.mark.parametrize("name", ["solution.json", "play.json", "joint_table.json"])
def test_a_record_without_what_a_robot_needs_is_refused_with_what_is_missing(tmp_path, name):
    write_table(tmp_path / "joint_table.csv", gait())
    needed = NOTHING_STATED if name == "solution.json" else {"cycle_duration_s": None, "transient": False}
    for key in needed:
        (tmp_path / name).write_text(json.dumps({k: v for k, v in needed.items() if k != key}))
        with pytest.raises(InputError, match=rf"{name}: lacks `{key}`, .*Write the results again"):
            read_table(tmp_path)
    (tmp_path / name).write_text("{}")
    with pytest.raises(InputError, match="lacks `cycle_duration_s`.* and `"):
        read_table(tmp_path)
    (tmp_path / name).write_text(json.dumps(needed))
    assert read_table(tmp_path).closed


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "is empty. A joint table has a header"),
        ("a,b\n1,2\n", "the header must be joint_1,joint_2 with 2 joints, got 'a,b'"),
        ("joint_1,joint_2\n1,2\n1,2\n", "at least 3 rows"),
        ("joint_1,joint_2\n1,2\n3\n1,2\n", ":3: needs 2 numbers, got 1"),
        *(
            (f"joint_1,joint_2\n1,2\n3,{x}\n1,2\n", "joint_2 is .*, not a number")
            for x in ("x", "inf", "1_0", "\uff11", "")
        ),
    ],
)
def test_malformed_table_is_refused_with_its_line(tmp_path, text, complaint):
    (tmp_path / "t.csv").write_text(text)
    with pytest.raises(InputError, match=complaint):
        read_table(tmp_path / "t.csv")


def test_binary_file_and_missing_file_are_refused(tmp_path):
    (tmp_path / "t.csv").write_bytes(b"\x80\xfe\x00\x01")
    with pytest.raises(InputError, match="not a text file"):
        read_table(tmp_path / "t.csv")
    with pytest.raises(InputError, match="Name a results folder"):
        read_table(tmp_path)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"id": 2}, "servo ID 2 is used by two joints"),
        ({"id": 300}, "less than or equal to 252"),
        ({"sign": 0}, "1"),
        ({"minimum_ticks": 2500}, "`minimum_ticks` < `zero_ticks`"),
        (
            {"speed_limit_rpm": 100.0},
            "must be at most 61 rpm, what XL430-W250-T servos do at 12 V without load, got 100",
        ),
        ({"speed": 1.0}, "unknown key"),
    ],
)
def test_bad_robot_file_is_refused(change, complaint):
    data = read_toml(ROBOT_FILE)
    data["joint"][0].update(change)
    with pytest.raises(InputError, match=complaint):
        validate(Robot, data, "robot.toml")


def test_baud_rate_must_be_one_that_the_servo_knows():
    data = read_toml(ROBOT_FILE)
    data["bus"]["baud_rate"] = 12345
    with pytest.raises(InputError, match="`baud_rate` must be one of 9600, 57600"):
        validate(Robot, data, "robot.toml")
