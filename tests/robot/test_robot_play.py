"""`serpenoid play` as a real subprocess over the real SDK against emulated servos: the good way, faults, stops.

Each ends with torque off, a clear message, a log that is readable to its last row, and its exit code.
"""

import contextlib
import json
import os
import pty
import re
import signal
import subprocess
import termios
import threading
import time
import tty

import numpy as np
import pytest
import serial
from emulated import (
    ROBOT_FILE,
    command,
    emulator,
    environment,
    gait,
    interrupt,
    play_words,
    read_log,
    robot,
    serpenoid,
    start,
    wait_for_rows,
    write_gait,
)

from robot import servo_process
from serpenoid.errors import InputError
from serpenoid.robot.bus import open_bus
from serpenoid.robot.table import read_table, write_table
from serpenoid.robot.ticks import to_radians, to_ticks

pytestmark = pytest.mark.usefixtures("serial_ports")

GROUPS = ("command", "position", "voltage", "load", "temperature", "error")


def test_gait_is_played_on_schedule_and_recorded(tmp_path):
    with emulator(tmp_path) as rig:
        done = serpenoid(*play_words(write_gait(tmp_path), rig.port, tmp_path / "log", cycles=2, pause=0.3))
        assert done.returncode == 0, done.stderr
        assert "torque is off on every servo" in done.stdout
        assert re.search("tracking: (largest error|no joint differs from its command) beyond the lag", done.stdout)
        assert not any(rig.torques)
        rig.check_limits()
    header, rows = read_log(tmp_path / "log" / "servo.csv")
    assert header == ["t_s", "phase", "cycle", "step", *(f"{g}_{j}" for g in GROUPS for j in range(1, 11))]
    summary = json.loads((tmp_path / "log" / "play.json").read_text())
    check_schedule(rows, summary["timing"]["given_up_readings"])
    check_values(rows)
    check_summary(tmp_path / "log")


def test_a_transient_is_played_to_its_last_row_and_recorded_without_a_trial_section(tmp_path):
    folder = tmp_path / "there"
    folder.mkdir()
    ramp = 0.02 * np.arange(11)[:, None] * np.ones(10)
    write_table(folder / "joint_table.csv", ramp)
    record = {"cycle_duration_s": None, "transient": True, "body": {}, "limits_held": {}}
    (folder / "solution.json").write_text(json.dumps(record))
    with emulator(tmp_path) as rig:
        done = serpenoid(*play_words(folder, rig.port, tmp_path / "log", cycles=1, pause=0.1))
        assert done.returncode == 0, done.stderr
    _, rows = read_log(tmp_path / "log" / "servo.csv")
    goals = [float(row["command_1"]) for row in rows if row["phase"] != "approach"]
    assert np.all(np.diff(goals) >= 0)
    assert goals[-1] == pytest.approx(0.2, abs=np.pi / 4096)  # half a tick
    assert rows[-1]["step"] == "10"
    assert not (tmp_path / "log" / "trial.toml").exists()
    recorded = json.loads((tmp_path / "log" / "play.json").read_text())
    assert "torque is off on every servo" in serpenoid("show", tmp_path / "log").stdout
    again = read_table(tmp_path / "log")  # what was recorded may be played again, as it was
    assert (again.closed, again.steps) == (False, 10)
    assert again.stated.cycle_duration_s == recorded["cycle_duration_s"]
    assert read_table(tmp_path / "log" / "joint_table.csv").closed is False


def check_schedule(rows, given_up):
    """Phases in order; every row of both cycles; row i of cycle n at t0 + n (cycle + pause) + i cycle / T."""
    phases = [row["phase"] for row in rows]
    assert phases.count("end") == 1
    assert [p for p, q in zip(phases, phases[1:], strict=False) if p != q] == [
        "approach",
        "play",
        "pause",
        "play",
        "pause",
    ]
    played = [row for row in rows if row["phase"] == "play"]
    places = [(int(row["cycle"]), int(row["step"])) for row in played]
    every = [(n, i) for n in range(2) for i in range(20)]
    assert places == [place for place in every if place in places]
    assert len(every) - len(places) <= given_up  # a busy machine gives readings up, and says so
    assert {row["step"] for row in rows if row["phase"] == "pause"} == {"20"}
    times = np.array([float(row["t_s"]) for row in played])
    due = np.array([n * 1.1 + i * 0.04 for n, i in places])
    # a busy machine may hold a row back, but never sends one early, and most leave in time: half a row is 20 ms
    late = times - times[0] - (due - due[0])
    assert np.median(np.abs(late)) < 0.02


def check_values(rows):
    table = to_radians(to_ticks(gait(), robot()), robot())
    for row in (row for row in rows if row["phase"] == "play"):
        commanded = [float(row[f"command_{j}"]) for j in range(1, 11)]
        # the log has six decimals
        assert np.allclose(commanded, table[int(row["step"])], atol=1e-6)
    last = rows[-1]
    measured = np.array([float(last[f"position_{j}"]) for j in range(1, 11)])
    # the emulated servo has settled within two ticks of row 0
    assert np.abs(measured - table[0]).max() < 2 * 2 * np.pi / 4096 + 1e-6
    assert all(11.0 < float(last[f"voltage_{j}"]) < 12.0 for j in range(1, 11))


def check_summary(folder):
    summary = json.loads((folder / "play.json").read_text())
    assert summary["status"] == "done"
    assert summary["torque_off"] is True
    assert summary["timing"]["rows"] == 2 * 21
    assert max(summary["timing"]["tracking"]["worst_deg"]) < 12
    assert 'servo_log = "log/servo.csv"' in (folder / "trial.toml").read_text()
    assert np.allclose(np.loadtxt(folder / "joint_table.csv", delimiter=",", skiprows=1), gait(), atol=np.pi / 4096)


FAULTS = {
    "silent:4@1.0": r"joint_4 \(ID 4\): no answer",
    "crc:4@1.0": r"joint_4 \(ID 4\): a corrupt answer",
    "delay:4@1.0=0.3": r"joint_4 \(ID 4\): no answer",
    "delay:3@1.0=0.05": r"joint_3 \(ID 3\) answers late",  # it holds up the answers of all behind it
    "delay:4@1.0=0.1": r"joint_4 \(ID 4\)|servo 4 failed",  # late answers meet later questions
    "overheat:4@1.0": r"joint_4 \(ID 4\) protects itself: overheating",
    "voltage@1.0=9.0": "battery: 9.0 V at the servos, `minimum_V` is 9.9 V",
    "voltage@1.0=5.5": "input voltage out of its limits",
    "reset:4@1.0": r"joint_4 \(ID 4\) has lost its torque",
    "unplug@1.0=0.3": "the port is lost",
}


# no answer, late ones, a servo that starts anew, no port; protecting itself: below; low battery: test_servo_models.py
QUICK = {"silent:4@1.0", "delay:3@1.0=0.05", "reset:4@1.0", "unplug@1.0=0.3"}


@pytest.mark.parametrize("fault", [pytest.param(f, marks=[] if f in QUICK else pytest.mark.slow) for f in FAULTS])
def test_fault_ends_with_torque_off_a_message_and_a_readable_log(tmp_path, fault):
    with emulator(tmp_path, fault) as rig:
        done = serpenoid(*play_words(write_gait(tmp_path), rig.port, tmp_path / "log", cycles=6))
        assert done.returncode == 1
        assert re.search(FAULTS[fault], done.stderr), done.stderr
        assert "Traceback" not in done.stderr
        assert not re.search(
            r"\(\(?\d+, ", done.stderr
        )  # the number of a system's error, and its words, as Python keeps them
        assert not any(rig.torques)
        rig.check_limits()
    _, rows = read_log(tmp_path / "log" / "servo.csv")
    assert rows[-1]["phase"] == "play"
    summary = json.loads((tmp_path / "log" / "play.json").read_text())
    assert summary["status"] == "failed"
    where = f"it ended in cycle {int(rows[-1]['cycle']) + 1} of 6, after step {rows[-1]['step']}"
    assert where in serpenoid("show", tmp_path / "log").stdout


def test_error_bits_of_an_overheated_servo_are_in_the_log(tmp_path):
    with emulator(tmp_path, "overheat:4@0.6=81") as rig:
        done = serpenoid(*play_words(write_gait(tmp_path), rig.port, tmp_path / "log"))
        assert not any(rig.torques)
    assert done.returncode == 1, done.stderr
    assert re.search(FAULTS["overheat:4@1.0"], done.stderr), done.stderr
    _, rows = read_log(tmp_path / "log" / "servo.csv")
    assert int(rows[-1]["error_4"]) & 0x04
    assert rows[-1]["temperature_4"] == "81"
    assert rows[-2]["error_4"] == "0"


def test_cable_that_stays_out_leaves_the_servos_stopped_by_their_watchdogs_and_says_so(tmp_path):
    with emulator(tmp_path, "unplug@0.6") as rig:
        done = serpenoid(*play_words(write_gait(tmp_path), rig.port, tmp_path / "log"))
        assert done.returncode == 1
        assert "bus watchdogs stop them within 0.50 s, but they may hold. CUT THE BATTERY" in done.stderr
        assert all(servo.table["bus_watchdog"] == -1 for servo in rig.chain.servos)
        assert all(servo.motion.velocity == 0 for servo in rig.chain.servos)
    summary = json.loads((tmp_path / "log" / "play.json").read_text())
    assert summary["torque_off"] is False


def test_servo_that_never_answered_is_no_emergency_as_nothing_was_switched_on(tmp_path):
    another = tmp_path / "another.toml"
    another.write_text(ROBOT_FILE.read_text().replace("id = 10\n", "id = 42\n"))
    with emulator(tmp_path) as rig:
        words = play_words(write_gait(tmp_path), rig.port, tmp_path / "log")
        done = serpenoid(*words, "--robot", another)
        assert done.returncode == 1
        assert "nothing was switched on; servos 42 did not answer" in done.stderr
        assert "CUT THE BATTERY" not in done.stderr
        assert not any(rig.torques)
    assert json.loads((tmp_path / "log" / "play.json").read_text())["torque_off"] is False
    assert "TORQUE MAY STILL BE ON" in serpenoid("show", tmp_path / "log").stdout


def test_bus_on_which_no_servo_answers_is_told_as_one_fault(tmp_path):
    slow = tmp_path / "slow.toml"
    slow.write_text(ROBOT_FILE.read_text().replace("baud_rate = 1000000", "baud_rate = 57600"))
    with emulator(tmp_path) as rig:
        done = serpenoid("robot", "check", write_gait(tmp_path), "--robot", slow, "--port", rig.port)
    assert done.returncode == 1
    assert "no servo answers at 57600 baud; asked for IDs 1, 2, 3, 4, 5, 6, 7, 8, 9, 10." in done.stderr
    assert "serpenoid robot scan tries others" in done.stderr
    assert "joint_1 " not in done.stderr


def test_servo_that_hears_nothing_is_stopped_by_its_watchdog_and_the_others_are_off(tmp_path):
    with emulator(tmp_path, "deaf:4@0.6") as rig:
        done = serpenoid(*play_words(write_gait(tmp_path), rig.port, tmp_path / "log"))
        assert done.returncode == 1
        assert "servos 4 did not confirm torque off" in done.stderr
        time.sleep(1.0)  # the watchdog is 0.5 s
        assert rig.torques == [i == 3 for i in range(10)]
        assert rig.chain.servos[3].table["bus_watchdog"] == -1


@pytest.mark.parametrize(
    "number",
    [
        signal.SIGINT,
        signal.SIGTERM,
        signal.SIGTSTP,  # Ctrl-Z would leave servos that hold
        *(pytest.param(number, marks=pytest.mark.slow) for number in (signal.SIGHUP, signal.SIGQUIT)),
    ],
)
def test_signal_ends_with_torque_off_and_exit_code_130(tmp_path, number):
    with emulator(tmp_path) as rig:
        process = start(*play_words(write_gait(tmp_path), rig.port, tmp_path / "log", cycles=50))
        wait_for_rows(tmp_path / "log" / "servo.csv")
        code, err = interrupt(process, number)
        assert code == 130
        assert f"stopped: by the user ({signal.Signals(number).name})" in err
        assert "torque is off on every servo" in err
        assert "Traceback" not in err
        assert not any(rig.torques)
    read_log(tmp_path / "log" / "servo.csv")


def test_impatient_second_interrupt_does_not_stop_the_torque_off(tmp_path):
    with emulator(tmp_path) as rig:
        process = start(*play_words(write_gait(tmp_path), rig.port, tmp_path / "log", cycles=50))
        wait_for_rows(tmp_path / "log" / "servo.csv")
        for _ in range(5):
            process.send_signal(signal.SIGINT)
            time.sleep(0.002)
        _, err = process.communicate(timeout=30)
        assert process.returncode == 130, err
        assert not any(rig.torques)


def test_killed_process_leaves_a_readable_log_and_the_next_run_recovers_the_servos(tmp_path):
    with emulator(tmp_path) as rig:
        process = start(*play_words(write_gait(tmp_path), rig.port, tmp_path / "log", cycles=50))
        wait_for_rows(tmp_path / "log" / "servo.csv")
        process.kill()
        process.communicate()
        time.sleep(1.0)  # two watchdogs long
        assert all(servo.table["bus_watchdog"] == -1 for servo in rig.chain.servos)
        assert all(servo.table["profile_velocity"] == 0 for servo in rig.chain.servos)
        _, rows = read_log(tmp_path / "log" / "servo.csv")
        assert rows[-1]["phase"] == "play"
        again = serpenoid(*play_words(write_gait(tmp_path), rig.port, tmp_path / "again", cycles=1))
        assert again.returncode == 0, again.stderr
        assert all(servo.table["profile_velocity"] > 0 for servo in rig.chain.servos)
        # the profile was rewritten after the trip: nothing was faster than the approach or the gait
        assert max(servo.fastest for servo in rig.chain.servos) < 40.0 * 4096 / 60


def test_stalled_computer_is_noticed(tmp_path):
    with emulator(tmp_path) as rig:
        process = start(*play_words(write_gait(tmp_path), rig.port, tmp_path / "log", cycles=50))
        wait_for_rows(tmp_path / "log" / "servo.csv")
        process.send_signal(signal.SIGSTOP)
        time.sleep(1.5)  # three watchdogs long
        code, err = interrupt(process, signal.SIGCONT)
        assert code == 1
        assert "watchdog" in err
        assert not any(rig.torques)


def test_port_is_held_by_one_process_alone(tmp_path):
    with emulator(tmp_path) as rig:
        process = start(*play_words(write_gait(tmp_path), rig.port, tmp_path / "log", cycles=50))
        wait_for_rows(tmp_path / "log" / "servo.csv")
        for words in (
            play_words(tmp_path / "gait.csv", rig.port, tmp_path / "second"),
            ["robot", "scan", "--port", rig.port],
        ):
            second = serpenoid(*words)
            assert second.returncode == 2
            assert "another program is using this port" in second.stderr
        assert not (tmp_path / "second").exists()
        assert process.poll() is None
        assert interrupt(process)[0] == 130


def test_foreign_program_on_the_port_is_respected(tmp_path):
    with emulator(tmp_path) as rig, serial.Serial(rig.port, 1000000, exclusive=True):
        done = serpenoid(*play_words(write_gait(tmp_path), rig.port, tmp_path / "log"))
        assert done.returncode == 2
        assert "another program is using this port" in done.stderr


def test_a_second_master_changes_nothing_of_the_port(tmp_path):
    with emulator(tmp_path) as rig, serial.Serial(rig.port, 1000000, exclusive=True) as first:
        with pytest.raises(InputError, match="another program is using this port"):
            open_bus(rig.port, 57600, {})
        assert termios.tcgetattr(first.fd)[4:6] == [termios.B1000000] * 2


def test_the_lock_of_a_port_is_its_own_and_leaves_nothing_behind(tmp_path):
    (tmp_path / "temporary").mkdir()
    with emulator(tmp_path) as rig:
        words = command("robot", "off", "--robot", ROBOT_FILE, "--port", rig.port)
        places = environment() | {"TMPDIR": str(tmp_path / "temporary")}
        assert subprocess.run(words, env=places, capture_output=True, check=False).returncode == 0
    assert not list((tmp_path / "temporary").iterdir())


def test_recording_is_never_overwritten(tmp_path):
    (tmp_path / "log").mkdir()
    (tmp_path / "log" / "servo.csv").write_text("precious")
    with emulator(tmp_path) as rig:
        done = serpenoid(*play_words(write_gait(tmp_path), rig.port, tmp_path / "log"))
        assert done.returncode == 2
        assert "a recording is already there" in done.stderr
        assert not any(rig.torques)
    assert (tmp_path / "log" / "servo.csv").read_text() == "precious"


def test_dry_run_prints_every_row_and_opens_no_port(tmp_path):
    words = ["--robot", ROBOT_FILE, "--port", "/no/such/port", "--cycles", 2, "--pause", 1, "--dry-run"]
    done = serpenoid("play", write_gait(tmp_path), *words)
    assert done.returncode == 0
    lines = done.stdout.splitlines()
    assert sum("cycle 1 step" in line for line in lines) == 21
    assert any("minimum_position_limit = 1138 1138" in line for line in lines)
    assert lines[-1].endswith("torque_enable = 0 on every servo")


def test_missing_servo_wrong_voltage_and_far_start_are_refused_before_anything_moves(tmp_path):
    with emulator(tmp_path) as rig:
        words = play_words(write_gait(tmp_path), rig.port, tmp_path / "log")
        rig.do(servo_process.supply, 6, 9.2)
        done = serpenoid(*words)
        assert done.returncode == 1
        assert "joint_7 (ID 7), before step 0: input voltage 9.2 V" in done.stderr
        rig.do(servo_process.supply, 6, 11.8)
        rig.do(servo_process.turn, 2, 3600.0)
        done = serpenoid(*words, "--log", tmp_path / "log2")
        assert "joint_3 (ID 3), step 0: the servo stands at 3600 ticks" in done.stderr
        rig.do(servo_process.take_out, 4)
        done = serpenoid(*words, "--log", tmp_path / "log3")
        assert "joint_5 (ID 5), before step 0: servo 5: no answer" in done.stderr
        assert not any(rig.torques)


def test_emulate_command_end_to_end(tmp_path):
    """The user's own rehearsal: emulate in one terminal, scan, check, play and off in another."""
    report = tmp_path / "report.json"
    words = ("robot", "emulate", "--robot", ROBOT_FILE, "--link", tmp_path / "snake", "--report", report)
    process = start(*words)
    port = process.stdout.readline().strip()
    try:
        scan = serpenoid("robot", "scan", "--port", port, "--baud-rate", 1000000)
        assert scan.returncode == 0
        assert scan.stdout.count("XL430-W250-T") == 10
        wrong = serpenoid("robot", "scan", "--port", port, "--baud-rate", 57600)
        assert wrong.returncode == 1
        check = serpenoid("robot", "check", write_gait(tmp_path), "--robot", ROBOT_FILE, "--port", port)
        assert "at 11.8 V (measured)" in check.stdout
        second = serpenoid(*words)
        assert second.returncode == 2
        assert f"--link {port}: another `robot emulate` serves this port" in second.stderr
        off = serpenoid("robot", "off", "--robot", ROBOT_FILE, "--port", port)
        assert off.returncode == 0
        assert serpenoid("robot", "reboot", "--robot", ROBOT_FILE, "--port", port).returncode == 0
    finally:
        code, err = interrupt(process)
    assert code == 0
    assert "torque is off on every servo" in err
    assert len(json.loads(report.read_text())["servos"]) == 10
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith((".", "snake"))] == []


def test_a_link_into_no_folder_is_refused(tmp_path):
    done = serpenoid("robot", "emulate", "--link", tmp_path / "nope" / "port")
    assert done.returncode == 2
    assert f"there is no folder {tmp_path / 'nope'}. Make it, or name another place." in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("target", "taken"), [("/dev/pts/99999", True), ("elsewhere", False), ("/dev/null", False)])
def test_a_link_that_no_emulator_made_is_not_replaced(tmp_path, target, taken):
    (tmp_path / "port").symlink_to(target)
    process = start("robot", "emulate", "--link", tmp_path / "port")
    if taken:  # what a killed emulator leaves
        assert process.stdout.readline().strip() == str(tmp_path / "port")
        assert interrupt(process)[0] == 0
    else:
        _, said = process.communicate(timeout=60)
        assert process.returncode == 2
        assert f"a link to {target} is already there, which no emulator made" in said
        assert os.readlink(tmp_path / "port") == target


def test_emergency_key_stops_the_robot(tmp_path):
    with emulator(tmp_path) as rig:
        words = play_words(write_gait(tmp_path), rig.port, tmp_path / "log", cycles=50)
        pid, terminal = pty.fork()
        if pid == 0:
            os.execve(command()[0], command(*words), environment())
        wait_for_rows(tmp_path / "log" / "servo.csv")
        os.write(terminal, b" ")
        said = read_to_the_end(terminal)
        _, status = os.waitpid(pid, 0)
        os.close(terminal)
        assert os.waitstatus_to_exitcode(status) == 1
        assert b"emergency stop: the space key was pressed" in said
        assert not any(rig.torques)


def read_to_the_end(terminal):
    """A pseudo-terminal ends with an error, when its other side is gone."""
    said = b""
    with contextlib.suppress(OSError):
        while data := os.read(terminal, 1024):
            said += data
    return said


def test_power_stream_is_recorded_beside_the_servo_log(tmp_path):
    master, slave = os.openpty()
    tty.setraw(slave)
    finished = threading.Event()

    def stream():
        k = 0
        os.write(master, b"5,11.1,0.4\n# hello\n")  # joined in the middle of a line; a comment
        while not finished.wait(0.01):
            os.write(master, f"{k * 0.01:.4f},11.1000,0.50000,5.550\nnan,1,1,1\n".encode())
            k += 1

    thread = threading.Thread(target=stream)
    thread.start()
    try:
        with emulator(tmp_path) as rig:
            words = play_words(write_gait(tmp_path), rig.port, tmp_path / "log", cycles=1)
            done = serpenoid(*words, "--power-port", os.ttyname(slave))
            assert done.returncode == 0, done.stderr
    finally:
        finished.set()
        thread.join()
        os.close(master)
        os.close(slave)
    header, *lines = (tmp_path / "log" / "power.csv").read_text().splitlines()
    assert header == "t_s,voltage_V,current_A,power_W"
    assert len(lines) > 20
    assert all(line.split(",")[1:] == ["11.1000", "0.50000", "5.5500"] for line in lines)
    assert "power_log" in (tmp_path / "log" / "trial.toml").read_text()


@pytest.mark.parametrize("words", [["play"], ["export"], ["robot"], ["robot", "check"], ["robot", "emulate"]])
def test_help_teaches_by_example(words):
    done = serpenoid(*words, "--help")
    assert done.returncode == 0
    assert re.search(r"^ *serpenoid ", done.stdout, re.MULTILINE)
