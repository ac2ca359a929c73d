"""Every model is whole, is played on the emulator of that model, and is not mistaken for another."""

import dataclasses
import json
import sys
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from emulated import ROBOT_FILE, XL430, gait, make_chain_of, play_words, read_log, robot, serpenoid, serving
from wire import recorded_play

from serpenoid.cli.main import main
from serpenoid.errors import InputError
from serpenoid.files.schema import load, read_toml, validate
from serpenoid.measure.logs import read_servo_log
from serpenoid.robot import models as package
from serpenoid.robot.checks import check_table
from serpenoid.robot.description import Robot
from serpenoid.robot.dry_run import describe
from serpenoid.robot.emulator.motion import Motion
from serpenoid.robot.emulator.servo import EmulatedServo
from serpenoid.robot.firmware import sketch
from serpenoid.robot.models import by_number, models
from serpenoid.robot.plan import make_plan
from serpenoid.robot.table import write_table
from serpenoid.robot.tracking import READINGS, Tracking

ALL = list(models().values())
EACH = pytest.mark.parametrize("servo", ALL, ids=lambda servo: servo.name)
# a servo with other voltages and a current; registers of all are compared with their tables in other tests
PLAYED = [pytest.param(s, id=s.name, marks=[] if s.name == "XL330-M288-T" else pytest.mark.slow) for s in ALL]
XM430, XL330 = models()["XM430-W350"], models()["XL330-M288-T"]


def test_models_are_found_by_listing_and_none_answers_for_another():
    files = {path.stem for path in Path(package.__file__).parent.glob("*.py")}
    assert len(ALL) == len(files - {"__init__", "servo_model", "x_series"})
    assert len({servo.number for servo in ALL}) == len(ALL)
    assert all(by_number(servo.number) is servo for servo in ALL)
    assert by_number(9999) is None


MADE_UP = """
import dataclasses
from serpenoid.robot.models.xm430_w350 import MODEL as xm430
MODEL = dataclasses.replace(xm430, name="MADE-UP", number=31000, voltage_range=(20.0, 30.0), recommended_V=24.0)
"""


def test_another_servo_is_one_file(tmp_path, monkeypatch):
    (tmp_path / "made_up.py").write_text(MADE_UP)
    monkeypatch.setattr(package, "__path__", [*package.__path__, str(tmp_path)])
    models.cache_clear()
    try:
        made_up = by_number(31000)
        assert made_up.name == "MADE-UP"
        data = read_toml(ROBOT_FILE) | {"model": "MADE-UP", "voltage": {"minimum_V": 22.0, "maximum_V": 28.0}}
        plan = make_plan(gait(), validate(Robot, data, "t"), 2.0, 1, 0.0)
        assert plan.robot.nominal_V == 24.0
        assert next(iter(describe(plan))).startswith("robot snake10: 10 servos MADE-UP at 1000000 baud")
        assert "{31000, 31000, 31000, 31000, 31000, 31000, 31000, 31000, 31000, 31000};  // MADE-UP" in sketch(plan)
    finally:
        models.cache_clear()
        sys.modules.pop("serpenoid.robot.models.made_up", None)


@EACH
def test_registers_do_not_overlap_and_initial_values_lie_in_their_ranges(servo):
    items = sorted(servo.registers.values(), key=lambda item: item.address)
    assert all(one.end <= other.address for one, other in pairwise(items))
    for name, item in servo.registers.items():
        bits = 8 * item.size - item.signed
        assert -(2**bits) * item.signed <= item.initial < 2**bits, name
        if item.low is not None:
            assert item.low <= item.initial <= item.high, name


@EACH
def test_no_load_speed_is_at_or_just_below_the_published_values(servo):
    for voltage, published in servo.no_load_points:
        # published speeds are whole rpm, their ratios to the voltage differ by up to 3 %
        assert 0.97 * published <= servo.no_load_speed_rpm(voltage) <= published * (1 + 1e-12)


@EACH
def test_what_a_model_recommends_its_own_limits_allow(servo):
    low, high = servo.voltage_range
    assert low <= servo.recommended_V <= high
    limits = [servo.registers[f"{end}_voltage_limit"].initial * servo.volt_per_unit for end in ("minimum", "maximum")]
    assert limits[0] <= low
    assert high <= limits[1]
    assert servo.baud_rates[servo.registers["baud_rate"].initial] == 57600
    assert set(servo.baud_rates) == set(range(servo.registers["baud_rate"].high + 1))
    # its factory's Velocity Limit is no tighter than what it does at what is recommended
    assert servo.registers["velocity_limit"].initial >= 0.95 * servo.velocity_units(servo.no_load_points[0][1])


def test_tracking_limits_are_three_quarters_of_full_output():
    # e-manual: output = P gain / 128 per tick, 885 is all of it; the XL430's gain is 640: 177 ticks, 15.6 degrees
    assert XL430.tracking_limit_deg == 12.0
    assert XM430.tracking_limit_deg == 10.0  # gain 800: 12.4 degrees
    assert XL330.tracking_limit_deg == 19.0  # gain 400: 24.9 degrees


@EACH
def test_an_emulated_shaft_turns_as_fast_as_its_model_and_no_faster(servo):
    motion, fastest = Motion(0.0, servo), servo.no_load_speed_rpm(servo.recommended_V) * 4096 / 60
    motion.advance(1.0, 1e9, 0, 0, servo.recommended_V)
    assert motion.position <= fastest
    # the lag of 20 ms, and the step of 2 ms
    assert motion.position == pytest.approx(fastest, rel=0.03)


@EACH
def test_an_emulated_servo_protects_itself_at_its_models_limits(servo):
    emulated = EmulatedServo(servo, 1, 3)
    emulated.advance(0.0)
    assert emulated.table["hardware_error_status"] == 0
    emulated.supply_voltage = servo.registers["maximum_voltage_limit"].initial * servo.volt_per_unit + 0.2
    emulated.temperature = servo.registers["temperature_limit"].initial + 1
    emulated.advance(0.1)
    assert servo.name_hardware_errors(emulated.table["hardware_error_status"]).startswith("input voltage out of")
    assert emulated.table["hardware_error_status"] == 5


@EACH
def test_an_emulated_servo_that_is_held_back_tells_full_load_or_its_stall_current(servo):
    emulated = EmulatedServo(servo, 1, 3)
    emulated.motion.fastest_rpm = 0.0
    for name, value in (("goal_position", 3000), ("profile_velocity", 400), ("torque_enable", 1)):
        emulated.table[name] = value
    for k in range(200):
        emulated.advance(0.01 * k)
    told = emulated.table[servo.effort.register] * servo.effort.per_unit
    assert told == pytest.approx(servo.effort.full, abs=servo.effort.per_unit)


@contextmanager
def rehearsal(folder, *kinds, fault=()):
    """Emulated servos of these models, and a robot file as `new robot` writes it for the first of them."""
    words = ("--yes", "--joints", str(len(kinds)), "--model", kinds[0].name)
    assert main(["new", "robot", str(folder / "mine.toml"), *words]) == 0
    write_table(folder / "gait.csv", gait(joints=len(kinds)))
    middle = round(kinds[0].recommended_V * 10) * 0.1
    with serving(make_chain_of(kinds, fault), folder) as rig:
        assert rig.chain.servos[0].supply_voltage == pytest.approx(middle, abs=0.8)
        yield rig


def play(folder, rig, *more):
    words = play_words(folder / "gait.csv", rig.port, folder / "log", cycles=1)
    words[words.index("--robot") + 1] = folder / "mine.toml"
    return serpenoid(*words, *more)


@pytest.mark.parametrize("servo", PLAYED)
def test_a_new_robots_file_is_scanned_checked_and_played_on_servos_of_its_model(tmp_path, servo, serial_ports):
    with rehearsal(tmp_path, servo, servo) as rig:
        scan = serpenoid("robot", "scan", "--port", rig.port, "--baud-rate", 1000000)
        assert scan.stdout.count(f"  {servo.name}  firmware 45  1000000 baud  2048 ticks") == 2, scan.stderr
        words = ("robot", "check", tmp_path / "gait.csv", "--robot", tmp_path / "mine.toml", "--port", rig.port)
        checked = serpenoid(*words, "--cycle-duration", 0.8)
        assert checked.returncode == 0, checked.stderr
        done = play(tmp_path, rig)
        assert done.returncode == 0, done.stderr
        assert not any(rig.torques)
        assert all(emulated.table["operating_mode"] == servo.position_mode for emulated in rig.chain.servos)
    assert json.loads((tmp_path / "log" / "play.json").read_text())["servos"] == [servo.name] * 2
    header, rows = read_log(tmp_path / "log" / "servo.csv")
    effort = servo.effort.column
    assert [c for c in header if c.startswith(("load", "current", "supply"))] == [f"{effort}_1", f"{effort}_2"]
    assert max(abs(float(row[f"{effort}_1"])) for row in rows) <= servo.effort.full + servo.effort.per_unit
    # as the gait asks: 0.15 rad
    assert max(float(row["position_1"]) for row in rows) == pytest.approx(0.15, abs=0.03)
    table = np.loadtxt(tmp_path / "log" / "joint_table.csv", delimiter=",", skiprows=1)
    assert np.abs(table - gait(joints=2)).max() <= np.pi / 4096 + 1e-9


def test_the_xl430s_bytes_are_those_before_there_were_other_models(tmp_path, serial_ports):
    """Recorded with the release in which the XL430 was the only one: tests/robot/xl430_packets.txt."""
    before = (Path(__file__).parent / "xl430_packets.txt").read_text().split()
    once, repeated = recorded_play(tmp_path)
    assert [*once, "repeated", *repeated] == before


@pytest.mark.parametrize("verb", ["check", "play"])
def test_another_model_than_the_files_is_refused_with_what_to_do(tmp_path, verb, serial_ports):
    with rehearsal(tmp_path, XM430, XL430) as rig:
        words = ("robot", "check", tmp_path / "gait.csv", "--robot", tmp_path / "mine.toml", "--port", rig.port)
        done = serpenoid(*words) if verb == "check" else play(tmp_path, rig)
        assert done.returncode == 1
        assert not any(rig.torques)
    assert (
        "joint_2 (ID 2), before step 0: model number 1060, an XL430-W250-T; `model` is XM430-W350 (1020). Correct the "
        'ID or the servo, or write model = "XL430-W250-T" in the robot file (in its [[joint]] if others differ).'
    ) in done.stderr


def test_a_servo_of_an_unknown_model_is_said_and_not_read(tmp_path, serial_ports):
    strange = dataclasses.replace(
        XL430,
        registers=XL430.registers | {"model_number": dataclasses.replace(XL430.registers["model_number"], initial=350)},
    )
    with serving(make_chain_of([strange]), tmp_path) as rig:
        scan = serpenoid("robot", "scan", "--port", rig.port, "--baud-rate", 1000000)
    assert "ID   1  model number 350  firmware 45  1000000 baud  not a model that is known here" in scan.stdout


def mixed():
    """The robot of the other tests with strong servos amid."""
    data = read_toml(ROBOT_FILE)
    data["voltage"] |= {"minimum_V": 10.0}
    del data["tracking"]["limit_deg"]
    for joint in data["joint"][4:6]:
        joint["model"] = "XM430-W350"
    return data


def test_a_chain_of_two_models_is_played_and_each_servo_is_asked_by_its_own(tmp_path, serial_ports):
    text = ROBOT_FILE.read_text().replace("minimum_V = 9.9", "minimum_V = 10.0")
    sections = text.split("[[joint]]")
    sections[5] = f'\nmodel = "XM430-W350"{sections[5]}'
    (tmp_path / "mine.toml").write_text("[[joint]]".join(sections))
    kinds = [XL430] * 4 + [XM430] + [XL430] * 5
    assert load(Robot, tmp_path / "mine.toml").servos == kinds
    write_table(tmp_path / "gait.csv", gait())
    with serving(make_chain_of(kinds), tmp_path) as rig:
        done = play(tmp_path, rig)
        assert done.returncode == 0, done.stderr
    header, rows = read_log(tmp_path / "log" / "servo.csv")
    assert header[header.index("voltage_10") + 1 :][:10] == [
        f"{'current' if j == 5 else 'load'}_{j}" for j in range(1, 11)
    ]
    read = read_servo_log(tmp_path / "log" / "servo.csv")  # a campaign takes what `play` wrote
    assert read.position.shape == (len(rows), 10)
    unit = max(float(row["current_5"]) for row in rows) / XM430.effort.per_unit
    assert unit == pytest.approx(round(unit), abs=0.2)  # the log has milliamperes


def test_a_gait_behind_gears_is_played_and_logged_as_joint_angles(tmp_path, serial_ports):
    (tmp_path / "mine.toml").write_text(
        ROBOT_FILE.read_text().replace("\nspeed_limit_rpm = ", "\ngear_ratio = 1.5\nspeed_limit_rpm = ")
    )
    write_table(tmp_path / "gait.csv", gait(amplitude=0.4))
    with serving(make_chain_of([XL430] * 10), tmp_path) as rig:
        done = play(tmp_path, rig)
        assert done.returncode == 0, done.stderr
        turned = [servo.highest - servo.lowest for servo in rig.chain.servos]
    _, rows = read_log(tmp_path / "log" / "servo.csv")
    positions = [float(row["position_5"]) for row in rows if row["phase"] == "play"]
    assert max(positions) - min(positions) == pytest.approx(0.8, abs=0.03)  # the lag rounds the crests off
    assert turned[4] == pytest.approx(1.5 * 0.8 * 4096 / (2 * np.pi), rel=0.05)


def test_servos_of_a_chain_that_no_one_supply_suits_are_told_so_and_not_one_voltage_after_the_other():
    data = mixed()
    data["joint"][4]["model"] = "XL330-M288-T"
    with pytest.raises(ValueError, match=r"XL330-M288-T servos \(3.7 to 6 V\) and XM430-W350 servos .* no one supply"):
        Robot.model_validate(data)


def test_each_joint_of_a_mixed_chain_has_its_own_tracking_limit():
    chain = validate(Robot, mixed(), "t")
    assert chain.tracking_limits_deg.tolist() == [12.0] * 4 + [10.0] * 2 + [12.0] * 4
    assert chain.in_words() == "8 servos XL430-W250-T and 2 servos XM430-W350"
    tracking = Tracking(
        chain.model_copy(update={"tracking": chain.tracking.model_copy(update={"action": "warn"})}), 9.0
    )
    tracking.sent(0.0, np.full(10, 2048))
    for k in range(READINGS):
        tracking.read(0.1 * k, np.full(10, 2048 + round(11.0 * 4096 / 360)))
    assert tracking.strayed == ["joint_5 (ID 5)"]


def test_speeds_are_checked_against_each_servos_own_motor():
    data = mixed()
    for joint in data["joint"]:
        joint["speed_limit_rpm"] = 57.0
    data["joint"][4]["speed_limit_rpm"] = 46.0
    refusals = [str(refusal) for refusal in check_table(gait(50, 0.8), validate(Robot, data, "t"), 1.1, 11.1)]
    assert [text.partition(",")[0] for text in refusals] == ["joint_5 (ID 5)", "joint_6 (ID 6)"]  # 43.6 rpm at the most
    assert all("the limit is 42.5 rpm (no-load speed at 11.1 V)" in text for text in refusals)


def test_models_whose_goals_stand_elsewhere_share_no_chain(monkeypatch):
    goal = dataclasses.replace(XL430.registers["goal_position"], address=564)
    other = dataclasses.replace(XL430, name="OTHER", registers=XL430.registers | {"goal_position": goal})
    known = models() | {"OTHER": other}
    monkeypatch.setattr("serpenoid.robot.description.models", lambda: known)
    data = read_toml(ROBOT_FILE)
    data["joint"][9]["model"] = "OTHER"
    with pytest.raises(InputError, match="XL430-W250-T and OTHER servos keep goal, torque or state elsewhere"):
        validate(Robot, data, "t")


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"model": "XM430-W350", "voltage": {"minimum_V": 5.0, "maximum_V": 12.6}},
         r"t: XM430-W350 servos need 10 to 14.8 V; `minimum_V` is 5\."),
        ({"model": "XL330-M288-T"}, r"XL330-M288-T servos need 3.7 to 6 V; `minimum_V` is 9.9"),
        ({"model": "XC330-M288-T", "voltage": {"minimum_V": 4.5, "maximum_V": 5.5}, "bus": {"baud_rate": 4500000}},
         r"`baud_rate` must be one of 9600, .*, 4000000 for XC330-M288-T servos, got 4500000"),
        ({"model": "XM430-W350-R"}, r"model: must be one of MX-106-2.0, .*, got .*Did you mean `XM430-W350`\?"),
        ({"model": "XM540-W270"}, r"\[\[joint\]\] 1 speed_limit_rpm: must be at most 37 rpm, what XM540-W270"),
        ({"model": 5}, r"model: Input should be a valid string"),
        ({"voltage": {"minimum_V": 11.5, "maximum_V": 12.6}}, "without a word `nominal_V` is 11.1"),
    ],
)  # fmt: skip
def test_what_a_model_cannot_do_is_refused_in_words(change, complaint):
    data = read_toml(ROBOT_FILE) | change
    with pytest.raises(InputError, match=complaint) as refused:
        validate(Robot, data, "t")
    if "Did you mean" in complaint:
        assert str(refused.value).count("\n") == 0  # said once, not again for every joint


def test_ticks_beyond_a_turn_are_refused():
    data = read_toml(ROBOT_FILE)
    data["joint"][2]["maximum_ticks"] = 4096
    with pytest.raises(
        InputError, match=r"\[\[joint\]\] 3 maximum_ticks: must be at most 4095, the last tick of XL430"
    ):
        validate(Robot, data, "t")


def test_what_the_file_leaves_out_is_the_models():
    data = read_toml(ROBOT_FILE)
    del data["voltage"]["nominal_V"], data["tracking"], data["model"]
    plain = validate(Robot, data, "t")
    assert plain.nominal_V == 11.1
    assert plain.tracking_limits_deg.tolist() == [12.0] * 10 == robot().tracking_limits_deg.tolist()
    assert plain.servos == [XL430] * 10


def test_new_robot_refuses_what_its_servos_cannot_do(tmp_path):
    for words, complaint in (
        (("--model", "XM540-W270", "--speed-limit", "50"), "--speed-limit: XM540-W270 servos do 37 rpm at 14.8 V"),
        (("--model", "XL330-M077-T", "--baud-rate", "4500000"), "--baud-rate: XL330-M077-T servos know 9600"),
        (("--model", "AX-12"), "--model: needs one of MX-106-2.0"),
    ):
        done = serpenoid("new", "robot", tmp_path / "mine.toml", "--yes", "--joints", 3, *words)
        assert done.returncode == 2
        assert complaint in done.stderr
        assert not (tmp_path / "mine.toml").exists()


def test_a_low_supply_stops_a_five_volt_robot(tmp_path, serial_ports):
    with rehearsal(tmp_path, XL330, XL330, fault=["voltage@0.3=4.2"]) as rig:
        done = play(tmp_path, rig, "--cycles", 5)
        assert done.returncode == 1
        assert "battery: 4.2 V at the servos, `minimum_V` is 4.5 V" in done.stderr
        assert not any(rig.torques)


def test_the_arena_has_motors_of_one_model(tmp_path):
    done = serpenoid("robot", "emulate", "--robot", ROBOT_FILE, "--arena", "--model", "XM430-W350")
    assert done.returncode == 2
    assert "--arena: its robot has motors of XL430-W250-T, not of XM430-W350 servos. Leave --arena out" in done.stderr
    done = serpenoid("robot", "emulate", "--model", "XL330-M288-T", "--baud-rate", "4500000")
    assert "--baud-rate must be one of 9600, 57600, 115200, 1000000, 2000000, 3000000, 4000000 for XL330" in done.stderr


def test_the_documentation_lists_every_model_with_its_numbers():
    page = (Path(__file__).parents[2] / "docs" / "robot.md").read_text()
    for servo in ALL:
        low, high = servo.voltage_range
        volts, fastest = servo.fastest
        effort = servo.effort.column.replace("_", " ")
        row = f"| {servo.name} | {servo.number} | {low:g} to {high:g} | {fastest:g} at {volts:g} V | {effort} | "
        assert f"{row}{servo.tracking_limit_deg:g} |" in page, row
