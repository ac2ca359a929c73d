"""Exports are read back: CSV and ticks exactly, the ROS 2 trajectory by the MCAP reader and by a YAML reader."""

import json
import re

import numpy as np
import pytest
from emulated import ROBOT_FILE, gait, robot, serpenoid, write_gait

from serpenoid.errors import InputError
from serpenoid.robot import ros
from serpenoid.robot.angles import paced
from serpenoid.robot.table import read_table, write_table
from serpenoid.robot.ticks import to_ticks


def export(folder, name, *words):
    return serpenoid("export", write_gait(folder), "--format", name, "--out", folder / "out", *words)


def test_csv_and_ticks_are_read_back(tmp_path):
    assert export(tmp_path, "csv").returncode == 0
    assert np.array_equal(read_table(tmp_path / "out").angles, gait())
    assert export(tmp_path, "ticks", "--robot", ROBOT_FILE).returncode == 0
    ticks = np.loadtxt(tmp_path / "out" / "ticks.csv", delimiter=",", skiprows=1, dtype=int)
    assert np.array_equal(ticks, to_ticks(gait(), robot()))


def test_angles_for_a_controller_of_ones_own_are_the_gait_at_its_pace_in_its_unit_and_signs(tmp_path):
    """A sine in a table so fine that straight lines between rows are it, against the sine itself at 50 Hz."""
    phases = 2 * np.pi * np.arange(1000) / 1000
    shifts = np.arange(4)
    write_table(tmp_path / "sine.csv", 0.5 * np.sin(phases[:, None] + shifts))
    out = tmp_path / "out"
    words = ["export", tmp_path / "sine.csv", "--format", "angles", "--out", out, "--cycle-duration", "2.5"]
    done = serpenoid(*words, "--rate", "50", "--signs=-1,1,1,1", "--zeros", "90,0,0,0")
    assert done.returncode == 0, done.stderr
    assert (out / "angles.csv").read_text().splitlines()[0] == "joint_1_deg,joint_2_deg,joint_3_deg,joint_4_deg"
    told = np.loadtxt(out / "angles.csv", delimiter=",", skiprows=1)
    moments = 2 * np.pi * np.arange(125) / 125
    angles = 0.5 * np.sin(moments[:, None] + shifts)
    # a line under an arc of 2 pi / 1000: 0.5 (2 pi / 1000)^2 / 8 rad; rounding: 5e-5 degrees
    np.testing.assert_allclose(told, np.degrees(angles) * [-1, 1, 1, 1] + [90, 0, 0, 0], atol=2e-4)
    again = read_table(out)
    np.testing.assert_allclose(again.angles, angles, atol=3e-6)
    assert again.stated.cycle_duration_s == 2.5


def test_a_transient_for_a_controller_of_ones_own_keeps_its_first_and_last_row():
    ramp = np.linspace(0, 1, 11)[:, None] * [1.0, -1.0]
    np.testing.assert_allclose(paced(ramp, False, 1.0, 20.0), np.linspace(0, 1, 21)[:, None] * [1.0, -1.0], atol=1e-15)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--rate", "50", "--cycle-duration", "2.03"], "2.03 s are 101.5 rows.*--cycle-duration 2.02 or 2.04"),
        (["--rate", "0", "--cycle-duration", "2"], "--rate must be above 0 rows a second"),
        (["--rate", "50"], "Give --cycle-duration S"),
        (["--signs=1,-1"], "--signs must be one number, or 10 numbers with commas"),
        (["--signs=2"], "--signs must be 1 or -1"),
        (["--zeros", "90;90"], "--zeros must be one number"),
    ],
)
def test_angles_that_no_controller_could_mean_are_refused(tmp_path, words, said):
    done = export(tmp_path, "angles", *words)
    assert done.returncode == 2
    assert re.search(said, done.stderr), done.stderr
    assert not (tmp_path / "out" / "angles.csv").exists()


def test_signs_beside_another_format_are_refused(tmp_path):
    done = export(tmp_path, "csv", "--signs=-1")
    assert (done.returncode, "--signs: is for --format angles" in done.stderr) == (2, True)


@pytest.mark.parametrize("out", ["out", "mine.csv"])
def test_an_exported_table_keeps_what_its_results_state_of_it(tmp_path, out):
    write_table(tmp_path / "joint_table.csv", gait())
    stated = {"transient": True, "cycle_duration_s": 7.0, "body": {"joint_limit_deg": 60.0}, "limits_held": {}}
    (tmp_path / "solution.json").write_text(json.dumps(stated))
    assert serpenoid("export", tmp_path, "--format", "csv", "--out", tmp_path / "a" / out).returncode == 0
    first, again = read_table(tmp_path), read_table(tmp_path / "a" / out)
    assert again.stated == first.stated
    assert (again.steps, again.closed) == (len(gait()) - 1, False)
    words = ["--format", "csv", "--out", tmp_path / "b", "--cycle-duration"]
    assert serpenoid("export", tmp_path, *words, 9).returncode == 0
    assert read_table(tmp_path / "b").stated.cycle_duration_s == 9.0
    done = serpenoid("export", tmp_path, *words, "nan")
    assert (done.returncode, "--cycle-duration must be above 0" in done.stderr) == (2, True)


def test_a_gait_in_space_is_exported_as_csv_alone(tmp_path):
    write_table(tmp_path / "joint_table.csv", 0.1 * gait(), in_space=True)
    words = ["export", tmp_path, "--out", tmp_path / "out", "--format"]
    assert serpenoid(*words, "csv").returncode == 0
    again = read_table(tmp_path / "out", any_table=True)
    assert np.array_equal(again.angles, 0.1 * gait())
    assert (again.columns[0], again.columns[-1], again.joints) == ("joint_1_yaw", "joint_5_pitch", 5)
    done = serpenoid(*words, "ros2", "--cycle-duration", 5)
    assert (done.returncode, "`serpenoid export RESULTS --format csv` without" in done.stderr) == (2, True)
    bad = tmp_path / "bad.csv"
    bad.write_text("joint_1_yaw,joint_1_pitch,joint_2_yaw,joint_2_pitch\n")
    with pytest.raises(InputError, match="must be joint_1_yaw,joint_2_yaw,joint_1_pitch,... with 2 joints, got"):
        read_table(bad, any_table=True)
    record = {"cycle_duration_s": None, "transient": False, "body": {"joint_limit_deg": 0.5}, "limits_held": {}}
    (tmp_path / "solution.json").write_text(json.dumps(record))
    done = serpenoid(*words, "csv", "--force")
    assert (done.returncode, "_yaw, step" in done.stderr or "_pitch, step" in done.stderr) == (1, True)


def test_formats_that_need_a_robot_or_a_duration_say_so(tmp_path):
    done = export(tmp_path, "openrb")
    assert (done.returncode, "needs --robot FILE" in done.stderr) == (2, True)
    done = export(tmp_path, "ros2")
    assert (done.returncode, "Give --cycle-duration S or --robot FILE" in done.stderr) == (2, True)


def test_a_sketch_has_a_name_that_the_arduino_tools_take(tmp_path):
    words = ["--format", "openrb", "--robot", ROBOT_FILE, "--out"]
    done = serpenoid("export", write_gait(tmp_path), *words, tmp_path / "my snake")
    assert (done.returncode, "a sketch is named as its folder" in done.stderr) == (2, True)
    assert not (tmp_path / "my snake").exists()
    assert serpenoid("export", write_gait(tmp_path), *words, tmp_path / "snake-1.b").returncode == 0


def test_refused_table_is_not_exported(tmp_path):
    bad = gait()
    bad[3, 0] = 2.0
    write_table(tmp_path / "bad.csv", bad)
    words = ["--format", "openrb", "--robot", ROBOT_FILE, "--out", tmp_path / "out"]
    done = serpenoid("export", tmp_path / "bad.csv", *words)
    assert done.returncode == 1
    assert "joint_1 (ID 1), step 3" in done.stderr
    assert not (tmp_path / "out").exists()


def read_mcap(path):
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        ((schema, channel, _, message),) = reader.iter_decoded_messages()
        return schema.name, channel.topic, message


def test_mcap_round_trip(tmp_path):
    assert export(tmp_path, "ros2", "--cycle-duration", 4, "--cycles", 2, "--pause", 1).returncode == 0
    schema, topic, message = read_mcap(tmp_path / "out" / "joint_trajectory.mcap")
    assert schema == "trajectory_msgs/msg/JointTrajectory"
    assert topic == "/joint_trajectory_controller/joint_trajectory"
    assert message.joint_names == [f"joint_{j}" for j in range(1, 11)]
    wanted = ros.make_trajectory(gait(), 4.0, 2, 1.0)
    assert np.array_equal([point.positions for point in message.points], wanted.positions)
    assert np.array_equal([point.velocities for point in message.points], wanted.velocities)
    times = [p.time_from_start.sec + p.time_from_start.nanosec * 1e-9 for p in message.points]
    # a nanosecond is the message's resolution
    assert np.allclose(times, wanted.times, atol=1e-9)


def test_yaml_says_the_same_as_the_mcap(tmp_path):
    import yaml

    assert export(tmp_path, "ros2", "--cycle-duration", 4).returncode == 0
    said = yaml.safe_load((tmp_path / "out" / "joint_trajectory.yaml").read_text())
    assert said == ros.to_message(ros.make_trajectory(gait(), 4.0, 1, 0.0))


@pytest.mark.parametrize(("cycles", "pause"), [(1, 0.0), (3, 0.0), (3, 2.0)])
def test_trajectory_ends_at_rest_on_row_0_and_time_increases(cycles, pause):
    path = ros.make_trajectory(gait(), 4.0, cycles, pause)
    assert path.times[0] > 0
    assert np.all(np.diff(path.times) > 0)
    for end in (0, -1):
        assert not path.velocities[end].any()
        assert np.array_equal(path.positions[end], gait()[0])
    assert path.times[-1] - path.times[0] == pytest.approx(cycles * (4.0 + pause))


def test_velocities_are_those_of_the_wave():
    """Central differences of a sampled sine are short by sin(h)/h, h = 2 pi / T: 1.6 % at T = 20."""
    path = ros.make_trajectory(gait(20, 0.15), 4.0, 1, 0.0)
    phase = np.arange(1, 20)[:, None] / 20 + np.arange(10) / 10
    exact = 0.15 * 2 * np.pi / 4.0 * np.cos(2 * np.pi * phase)
    h = 2 * np.pi / 20
    assert np.allclose(path.velocities[1:20], exact * np.sin(h) / h, atol=1e-12)


@pytest.mark.parametrize(("cycles", "pause"), [(1, 0.0), (1, 2.0)])
def test_a_transient_ends_at_rest_on_its_last_row_after_its_own_steps(cycles, pause):
    """A ramp of 0.05 rad a step: velocities inside are exact, both ends are at rest."""
    ramp = 0.05 * np.arange(11)[:, None] * np.ones(10)
    path = ros.make_trajectory(ramp, 4.0, cycles, pause, closed=False)
    assert np.array_equal(path.positions[:11], ramp)
    assert np.array_equal(path.positions[-1], ramp[-1])
    assert np.allclose(np.diff(path.times[:11]), 0.4)
    assert np.allclose(path.velocities[1:10], 0.05 / 0.4)
    assert not path.velocities[[0, *range(10, len(path.times))]].any()
