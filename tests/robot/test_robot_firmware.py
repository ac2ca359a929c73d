"""The OpenRB-150 sketch, compiled for the host against a board that checks bounds, order and timing, and run."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from emulated import ROBOT_FILE, XL430, gait, robot, serpenoid, write_gait

from serpenoid.errors import InputError
from serpenoid.files.schema import read_toml, validate
from serpenoid.robot.description import Robot
from serpenoid.robot.firmware import sketch
from serpenoid.robot.models import models
from serpenoid.robot.plan import make_plan

BOARD = Path(__file__).parent / "board"
COMPILER = shutil.which("g++") or shutil.which("clang++")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C++ compiler on this machine")
PLAN = make_plan(gait(), robot(), 2.0, 2, 0.5)
LATE_US = 400  # one look at clock and button, and the previous packet's last bytes


def build(folder, text, servo=XL430, joints=10):
    """Compile with every warning and sanitizer; return the program."""
    source = folder / "sketch.cpp"
    # the Arduino tools put a prototype of every function on top; here the include that all sketches get is enough
    source.write_text(f'#include "Arduino.h"\n{text}')
    flags = ["-std=c++17", "-O1", "-Wall", "-Wextra", "-Werror", "-fsanitize=address,undefined"]
    factory = servo.registers["velocity_limit"].initial
    volts = servo.registers["present_input_voltage"].initial
    said = {"JOINT_COUNT": joints, "MODEL_NUMBER": servo.number, "FACTORY_VELOCITY": factory, "DECIVOLT": volts}
    flags += [f"-D{name}={value}" for name, value in said.items()]
    files = [str(source), str(BOARD / "board.cpp")]
    program = folder / "sketch"
    done = subprocess.run(
        [COMPILER, *flags, "-fno-sanitize-recover", f"-I{BOARD}", *files, "-o", str(program)],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return program


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    return build(tmp_path_factory.mktemp("sketch"), sketch(PLAN, power_stream=True))


def run(program, *words):
    done = subprocess.run([program, *map(str, words)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout[-300:] + done.stderr[-2000:]
    return done.stdout.splitlines()


def rows_of(lines):
    """(time [s], goals) of every change of row; repeats feed the watchdogs."""
    rows = [line.split()[1:] for line in lines if line.startswith("row ")]
    parsed = [(int(row[0]) * 1e-6, [int(goal) for goal in row[1:]]) for row in rows]
    return [row for before, row in zip([(0, None), *parsed], parsed, strict=False) if row[1] != before[1]]


def torques(lines):
    return [int(line.split()[2]) for line in lines if line.startswith("final ")]


@needs_compiler
@pytest.mark.parametrize("clock", [[], ["wrap"]])
def test_sketch_plays_the_table_on_schedule_after_a_press_and_switches_off(program, clock):
    lines = run(program, 9, "press@0.5", *clock)
    rows = rows_of(lines)
    wanted = [row for _ in range(2) for row in PLAN.ticks.tolist()] + [PLAN.ticks[0].tolist()]
    # row 0 is the approach, then the first row of the first cycle: one change
    assert [goals for _, goals in rows] == [*wanted[:20], PLAN.ticks[0].tolist(), *wanted[21:40], wanted[40]]
    times = np.array([time for time, _ in rows])
    due = np.array([n * 2.5 + i * 0.1 for n in range(2) for i in range(1, 21)])
    played = np.array([*times[1:21], *times[21:]])
    steps_due = np.array([due[k] for k in range(20)] + [2.5 + i * 0.1 for i in range(1, 21)])
    late = played - steps_due
    assert np.ptp(late) * 1e6 < LATE_US
    assert torques(lines) == [0] * 10


@needs_compiler
def test_a_sketch_of_a_transient_ends_on_its_last_row(tmp_path):
    plan = make_plan(0.05 * np.arange(9)[:, None] * np.ones(10), robot(), 2.0, 1, 0.5, closed=False)
    rows = rows_of(run(build(tmp_path, sketch(plan)), 6, "press@0.5"))
    assert [goals for _, goals in rows] == plan.ticks.tolist()
    # 8 steps of 0.25 s; the first row stands from the approach on
    assert np.allclose(np.diff([time for time, _ in rows])[1:], 0.25, atol=LATE_US * 1e-6)


@needs_compiler
def test_sketch_waits_for_the_button(program):
    lines = run(program, 2)
    assert rows_of(lines) == []
    assert not any(line.startswith("torque ") and line.endswith(" 1") for line in lines)


@needs_compiler
def test_second_press_stops_at_once(program):
    lines = run(program, 9, "press@0.5", "press@3.0")
    off = [int(line.split()[1]) for line in lines if line.startswith("torque ") and line.endswith(" 0")]
    # a press is noticed within one look, and ten servos are switched off within 20 ms
    assert any(3.0e6 < moment < 3.03e6 for moment in off)
    assert rows_of(lines)[-1][0] < 3.01
    assert torques(lines) == [0] * 10


@needs_compiler
@pytest.mark.parametrize(
    ("event", "reason"),
    [
        ("error@3.0", "hardware error"),
        ("sag@3.0", "voltage"),
        ("gone@3.0", "voltage"),
        ("gone@0", "no servo of the robot file's model answers"),
        ("narrow@0", "its own limits are narrower than the robot file's"),
    ],
)
def test_fault_switches_torque_off_says_why_and_blinks(program, event, reason):
    lines = run(program, 9, "press@0.5", event)
    assert any(f"# fault: {reason}" in line for line in lines)
    assert sum(line.startswith("led ") for line in lines) > 10
    assert torques(lines) == [0] * 10


@needs_compiler
def test_sketch_streams_the_power_log(program):
    lines = run(program, 9, "press@0.5")
    power = [line.split(",") for line in lines if line.count(",") == 3]
    assert len(power) > 100
    assert all(cells[1:] == ["11.1000", "0.50000", "5.550"] for cells in power)
    assert np.all(np.diff([float(cells[0]) for cells in power]) > 0)


def test_table_is_const_int16_in_the_sketch():
    text = sketch(PLAN)
    assert "const int16_t TABLE[ROWS][JOINTS]" in text
    assert f"  {{{', '.join(map(str, PLAN.ticks[0]))}}}" in text
    assert "@" not in text
    assert "STREAM_POWER = false" in text


def test_tables_and_durations_that_the_board_cannot_hold_are_refused():
    with pytest.raises(InputError, match="bytes of flash"):
        sketch(make_plan(gait(20000), robot(), 600.0, 1, 0.0))
    long = make_plan(gait(), robot(), 600.0, 1, 600.0)
    assert sketch(long)  # 1200 s is below the clock's 2147 s


@needs_compiler
def test_exported_sketch_at_57600_baud_keeps_its_schedule(tmp_path):
    data = read_toml(ROBOT_FILE)
    data["bus"]["baud_rate"] = 57600
    plan = make_plan(gait(), validate(type(robot()), data, "t"), 2.0, 1, 0.5)
    rows = rows_of(run(build(tmp_path, sketch(plan)), 9, "press@0.5"))
    late = np.array([time for time, _ in rows[1:]]) - np.arange(1, 21) * 0.1
    assert np.ptp(late) * 1e6 < LATE_US


def test_export_command_writes_a_sketch_in_a_folder_of_its_name(tmp_path):
    words = ["--format", "openrb", "--robot", ROBOT_FILE, "--cycles", 3, "--pause", 2, "--out", tmp_path / "snake"]
    done = serpenoid("export", write_gait(tmp_path), *words)
    assert done.returncode == 0, done.stderr
    assert "const uint16_t CYCLES = 3" in (tmp_path / "snake" / "snake.ino").read_text()


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("arm-none-eabi-g++") is None, reason="no ARM cross compiler on this machine")
def test_sketch_compiles_for_the_board_s_processor(tmp_path):
    source = tmp_path / "sketch.cpp"
    source.write_text(f'#include "Arduino.h"\n{sketch(PLAN)}')
    flags = ["-std=gnu++17", "-mcpu=cortex-m0plus", "-mthumb", "-Os", "-Wall", "-c", f"-I{BOARD}"]
    done = subprocess.run(["arm-none-eabi-g++", *flags, source, "-o", tmp_path / "s.o"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@needs_compiler
def test_a_sketch_for_another_model_asks_for_it_and_keeps_its_numbers(tmp_path):
    """XL330-M288-T: model number 1200, Velocity Limit 445 from the factory, 4.5 to 5.5 V."""
    servo, joints = models()["XL330-M288-T"], 2
    data = read_toml(ROBOT_FILE) | {"model": servo.name, "voltage": {"minimum_V": 4.5, "maximum_V": 5.5}}
    data["joint"] = data["joint"][:joints]
    text = sketch(make_plan(gait(joints=joints), validate(Robot, data, "t"), 2.0, 1, 0.0))
    assert "MODEL[JOINTS] = {1200, 1200};  // XL330-M288-T" in text
    assert "MINIMUM_DECIVOLT = 45;" in text
    assert "FACTORY_SPEED_LIMIT[JOINTS] = {445, 445};" in text
    program = build(tmp_path, text, servo, joints)
    lines = run(program, 7, "press@0.5")
    assert len(rows_of(lines)) == 21  # and the first one again at the end
    assert torques(lines) == [0, 0]
    assert any("# fault: voltage" in line for line in run(program, 7, "press@0.5", "sag@1.0"))
    other = build(tmp_path, text, XL430, joints)
    assert any("no servo of the robot file's model answers" in line for line in run(other, 3, "press@0.5"))
