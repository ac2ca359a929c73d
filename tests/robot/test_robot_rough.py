"""What goes wrong beside the bus: a joint that does not follow, limits in a servo's own memory, refusals, full disks.

Every end says what became of the motors, and none of them is "done" with a gait that was not played.
"""

import json
import re
import resource
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from emulated import (
    ROBOT_FILE,
    command,
    emulator,
    environment,
    play_words,
    read_log,
    robot,
    serpenoid,
    wait_for_rows,
    write_gait,
)

from robot import servo_process
from serpenoid.errors import InputError
from serpenoid.robot.description import TrackingRule
from serpenoid.robot.faults import RobotFault
from serpenoid.robot.log import ServoLog
from serpenoid.robot.tracking import READINGS, RowClock, Tracking
from serpenoid.scaffold.add import _played

pytestmark = pytest.mark.usefixtures("serial_ports")


def robot_file(folder, tracking: str):
    path = folder / "robot.toml"
    head, rest = ROBOT_FILE.read_text().split("[tracking]")
    path.write_text(f"{head}[tracking]\n{tracking}\n\n{rest[rest.index('[[joint]]') :]}")
    return path


def play(folder, rig, *more, cycles=3, amplitude=0.3, name="log"):
    words = play_words(write_gait(folder, amplitude=amplitude), rig.port, folder / name, cycles=cycles)
    return serpenoid(*words, *more)


def summary(folder, name="log"):
    return json.loads((folder / name / "play.json").read_text())


def test_a_stuck_servo_stops_the_gait_with_torque_off_and_exit_code_1(tmp_path):
    with emulator(tmp_path, "stuck:4@0.5") as rig:
        done = play(tmp_path, rig)
        assert done.returncode == 1
        # which of the two shows first, is a matter of when it was stuck: the servos keep their own time
        strayed = r"is [\d.]+ degrees off its command, `limit_deg` in \[tracking\] is 12"
        assert re.search(rf"failed: joint_4 \(ID 4\) ({strayed}|did not move in a whole cycle of)", done.stderr)
        assert not any(rig.torques)
    assert summary(tmp_path)["status"] == "failed"


def test_a_stuck_servo_that_is_only_reported_is_played_to_the_end_and_is_not_done(tmp_path):
    with emulator(tmp_path, "stuck:4@0.5") as rig:
        done = play(tmp_path, rig, "--robot", robot_file(tmp_path, 'action = "warn"'), cycles=2)
        assert done.returncode == 1
        assert "strayed: played to the end, but joint_4 (ID 4) did not follow" in done.stderr
        assert not any(rig.torques)
    _, rows = read_log(tmp_path / "log" / "servo.csv")
    assert rows[-1]["phase"] == "end"
    timing = summary(tmp_path)["timing"]["tracking"]
    assert timing["strayed"] == ["joint_4 (ID 4)"]
    # it stood where it was stuck while the command went on to 0.3 rad, 17.2 degrees, on either side
    assert 12 < timing["worst_deg"][3] < 2 * 17.3
    assert (tmp_path / "log" / "trial.toml").read_text().startswith("# strayed")


def test_a_servo_that_is_too_slow_is_waited_for_and_one_that_is_blocked_is_not(tmp_path):
    # 0.3 rad at 0.8 s a cycle is 22 rpm at the most; with 6 rpm to be had it follows once the gait takes thrice as long
    rule = robot_file(tmp_path, 'action = "slow"\nlimit_deg = 8.0\nlag_s = 0.1')
    with emulator(tmp_path, "stuck:4@0.5=6") as rig:
        done = play(tmp_path, rig, "--robot", rule, cycles=2)
        assert done.returncode == 1
        assert "played to the end, and more slowly than asked" in done.stderr, done.stderr
    assert 1.5 <= summary(tmp_path)["timing"]["tracking"]["slowed_down"] <= 4
    with emulator(tmp_path, "stuck:4@0.5") as rig:
        done = play(tmp_path, rig, "--robot", rule, cycles=20, name="blocked")
        assert "though the gait was slowed down 3.4 times" in done.stderr, done.stderr
        assert not any(rig.torques)
    assert summary(tmp_path, "blocked")["status"] == "failed"


@pytest.mark.slow  # as test_robot_play.py asks of the gait that it plays
def test_a_healthy_gait_says_how_well_it_was_followed(tmp_path):
    with emulator(tmp_path) as rig:
        done = play(tmp_path, rig, cycles=1)
    assert done.returncode == 0, done.stderr
    assert re.search("tracking: (largest error|no joint differs from its command) beyond the lag", done.stdout)
    assert max(summary(tmp_path)["timing"]["tracking"]["worst_deg"]) < 12


def tracked(**rule) -> Tracking:
    return Tracking(robot().model_copy(update={"tracking": TrackingRule(**rule)}), 100.0)


def ticks(degrees: float) -> np.ndarray:
    return np.full(10, 2048 + round(degrees * 4096 / 360))


def test_a_servo_that_follows_late_is_not_off_its_command_however_fast_the_gait():
    tracking = tracked(limit_deg=1.0, lag_s=0.3)
    for k in range(200):  # a ramp of 200 degrees a second, followed 0.2 s late: 40 degrees behind
        tracking.sent(k * 0.01, ticks(2.0 * k))
        tracking.read(k * 0.01, ticks(max(0.0, 2.0 * (k - 20))))
    assert tracking.worst.max() == 0
    assert tracking.sentence() == "no joint differs from its command beyond the lag (the limit is 1 degrees)"


def test_a_joint_that_is_off_for_a_moment_is_not_stuck():
    tracking = tracked(limit_deg=5.0)
    tracking.sent(0.0, ticks(0.0))
    for k in range(50):
        tracking.read(0.1 * k, ticks(20.0 if k % READINGS else 0.0))
    assert tracking.worst.max() == pytest.approx(20.0, abs=0.1)
    tracking.read(5.0, ticks(0.0))
    for k in range(READINGS - 1):
        tracking.read(6.0 + 0.1 * k, ticks(20.0))
    with pytest.raises(RobotFault, match=r"joint_1 \(ID 1\) is 20\.0 degrees off its command"):
        tracking.read(7.0, ticks(20.0))


@pytest.mark.parametrize(("amplitude", "seen"), [(17.0, True), (8.0, True), (4.0, False)])
def test_a_shaft_that_stands_still_for_a_whole_cycle_is_seen_however_short_the_cycle(amplitude, seen):
    # 0.3 s of lag are most of a cycle of 0.4 s: some command of that time is always near the middle
    tracking = Tracking(robot().model_copy(update={"tracking": TrackingRule(action="warn")}), 0.4)
    for k in range(60):
        tracking.sent(0.02 * k, ticks(amplitude * np.sin(2 * np.pi * k / 20)))
        tracking.read(0.02 * k, ticks(0.0))
    assert bool(tracking.strayed) is seen
    assert tracking.worst.max() < 12


def test_a_shaft_that_moves_a_little_is_not_blocked():
    tracking = Tracking(robot().model_copy(update={"tracking": TrackingRule()}), 0.4)
    for k in range(60):
        command = np.sin(2 * np.pi * k / 20)
        tracking.sent(0.02 * k, ticks(10.0 * command))
        tracking.read(0.02 * k, ticks(4.0 * command))
    assert tracking.strayed == []


def test_rows_stay_in_order_when_the_clock_is_slowed_down():
    clock = RowClock(100.0)
    assert clock.due(2.0) == 102.0
    clock.stretch(1.5, 2.0)
    assert clock.due(2.0) == 102.0
    assert clock.due(4.0) == 105.0
    clock.stretch(2.25, 4.0)
    assert clock.due(5.0) == pytest.approx(107.25)


def narrow(rig, joint: int, **limits: int) -> None:
    rig.do(servo_process.remember, joint, limits)


def test_narrower_limits_in_a_servos_own_memory_hold_and_are_named(tmp_path):
    with emulator(tmp_path) as rig:
        narrow(rig, 3, maximum_position_limit=2400, velocity_limit=150)
        done = play(tmp_path, rig, cycles=1)
        assert done.returncode == 0, done.stderr
        assert "joint_4 (ID 4): in its own memory `maximum_ticks` is 2400, not 2958" in done.stdout
        assert "the narrower limit holds" in done.stdout
        assert rig.chain.servos[3].table["maximum_position_limit"] == 2400
        assert rig.chain.servos[3].table["velocity_limit"] == 150


def test_a_gait_beyond_a_servos_own_limit_is_refused_and_widening_is_asked_for_in_words(tmp_path):
    with emulator(tmp_path) as rig:
        narrow(rig, 3, maximum_position_limit=2100)
        done = play(tmp_path, rig, cycles=1)
        assert done.returncode == 1
        assert "joint_4 (ID 4), step" in done.stderr
        assert "(1138..2100 ticks)" in done.stderr
        assert "--widen-limits" in done.stderr
        assert rig.chain.servos[3].table["maximum_position_limit"] == 2100
        done = play(tmp_path, rig, "--widen-limits", cycles=1)
        assert done.returncode == 0, done.stderr
        assert "maximum_position_limit 2100 -> 2958 written to its memory" in done.stdout
        assert rig.chain.servos[3].table["maximum_position_limit"] == 2958


def test_check_on_the_bus_knows_a_servos_own_limits(tmp_path):
    with emulator(tmp_path) as rig:
        narrow(rig, 3, maximum_position_limit=2100)
        words = ("robot", "check", write_gait(tmp_path, amplitude=0.3), "--robot", ROBOT_FILE, "--port", rig.port)
        done = serpenoid(*words, "--cycle-duration", 2)
    assert done.returncode == 1
    assert "(1138..2100 ticks)" in done.stderr


def test_a_refused_trial_leaves_its_folder_free_for_the_next_attempt(tmp_path):
    with emulator(tmp_path) as rig:
        rig.do(servo_process.supply, 6, 9.2)
        assert "input voltage 9.2 V" in play(tmp_path, rig, cycles=1).stderr
        assert not (tmp_path / "log" / "servo.csv").exists()
        assert summary(tmp_path)["status"] == "failed"
        rig.do(servo_process.supply, 6, 11.8)
        done = play(tmp_path, rig, cycles=1)
    assert done.returncode == 0, done.stderr
    assert summary(tmp_path)["status"] == "done"


def test_messages_keep_their_dots(tmp_path):
    with emulator(tmp_path) as rig:
        rig.do(servo_process.supply, 6, 9.2)
        refused = play(tmp_path, rig, cycles=1).stderr
    assert "the window is 9.9..12.6 V. Charge the battery." in refused
    assert "battery..\n" not in refused


@pytest.mark.slow  # every byte in its order: test_servo_models.py; an unplugged robot: test_robot_play.py
def test_watchdogs_are_armed_before_torque_so_that_an_unplugged_robot_stops_itself(tmp_path):
    with emulator(tmp_path, "unplug@0.0") as rig:  # the moment the first servo has torque
        done = play(tmp_path, rig)
        assert done.returncode == 1
        assert "bus watchdogs stop them" in done.stderr
        on = [servo for servo in rig.chain.servos if servo.torque]
        assert on
        assert all(servo.table["bus_watchdog"] == -1 for servo in on)


def limited(bytes_: int):
    def apply() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (bytes_, bytes_))

    return apply


def test_a_full_disk_ends_with_torque_off_and_says_so(tmp_path):
    with emulator(tmp_path) as rig:
        words = play_words(write_gait(tmp_path), rig.port, tmp_path / "log", cycles=20)
        done = subprocess.run(
            command(*words),
            env=environment(),
            capture_output=True,
            text=True,
            timeout=60,
            stdin=subprocess.DEVNULL,
            preexec_fn=limited(6000),
        )
        assert done.returncode == 1
        assert "servo.csv: cannot be written any more (File too large)" in done.stderr
        assert "motors: torque is off on every servo" in done.stderr
        assert "Traceback" not in done.stderr
        assert not any(rig.torques)


def test_what_was_recorded_until_the_process_was_killed_can_be_used(tmp_path):
    """All that is known before a trial ends is on the disk before it moves; a full disk keeps as much."""
    with emulator(tmp_path) as rig:
        words = play_words(write_gait(tmp_path), rig.port, tmp_path / "log", cycles=20)
        with subprocess.Popen(command(*words), env=environment(), stdin=subprocess.DEVNULL) as playing:
            wait_for_rows(tmp_path / "log" / "servo.csv")
            playing.kill()
    assert summary(tmp_path)["status"] == "unfinished"
    assert {p.name for p in (tmp_path / "log").iterdir()} == {"servo.csv", "joint_table.csv", "trial.toml", "play.json"}
    with pytest.raises(InputError, match="unfinished: .*--anyway"):
        _played(tmp_path / "log", anyway=False)
    assert _played(tmp_path / "log", anyway=True)["cycles"] == 20


def test_a_trial_that_has_no_room_on_the_disk_is_refused(tmp_path, monkeypatch):
    usage = SimpleNamespace(free=1000)
    monkeypatch.setattr("serpenoid.robot.log.shutil.disk_usage", lambda folder: usage)
    log = ServoLog(tmp_path / "log", robot())
    with pytest.raises(InputError, match=r"takes up to \d+ kB, 1 kB are free. Make room, play fewer"):
        log.check_room(1000)


@pytest.mark.parametrize(
    "closed",
    [
        pytest.param(">&-", marks=pytest.mark.slow),
        pytest.param("2>&-", marks=pytest.mark.slow),
        pytest.param(">/dev/full", marks=pytest.mark.slow),
        ">&- 2>&-",
    ],
)
def test_a_closed_or_full_output_does_not_stop_the_robot_nor_hide_its_state(tmp_path, closed):
    with emulator(tmp_path) as rig:
        words = play_words(write_gait(tmp_path), rig.port, tmp_path / "log", cycles=1)
        line = f"exec {sys.executable} -m serpenoid {' '.join(map(str, words))} {closed}"
        done = subprocess.run(["sh", "-c", line], env=environment(), capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, done.stderr
        assert not any(rig.torques)
    assert summary(tmp_path)["status"] == "done"
    if closed != ">&- 2>&-":
        assert "motors: torque is off on every servo" in done.stdout + done.stderr
