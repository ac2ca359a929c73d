"""The emulator keeps the XL430's rules, and rubbish on the bus never crashes it or drives a servo out of its limits."""

import random

import numpy as np
import pytest
from emulated import HIGHEST, LOWEST, XL430, make_chain, serpenoid

from serpenoid.errors import InputError
from serpenoid.robot.emulator import packets
from serpenoid.robot.emulator.faults import parse_fault
from serpenoid.robot.emulator.memory import ACCESS, DATA_LENGTH, DATA_LIMIT, DATA_RANGE
from serpenoid.robot.emulator.motion import LAG_S, Motion

TICKS_PER_S_PER_UNIT = 0.229 * 4096 / 60
GAP_S = 0.1  # between two packets in these tests: the bus is free again


class Master:
    """Talks to a chain, one packet every GAP_S."""

    def __init__(self, chain):
        self.chain, self.now = chain, 0.0

    def send(self, raw):
        self.now += GAP_S
        return [p for reply in self.chain.receive(raw, self.now) for p in packets.Parser().feed(reply.data)]

    def write(self, servo_id, name, value):
        """The error number that the servo answers with."""
        register = XL430.registers[name]
        data = (value & (1 << 8 * register.size) - 1).to_bytes(register.size, "little")
        raw = packets.build(servo_id, packets.WRITE, register.address.to_bytes(2, "little") + data)
        return self.send(raw)[0].parameters[0] & 0x7F

    def read(self, servo_id, name):
        register = XL430.registers[name]
        question = register.address.to_bytes(2, "little") + register.size.to_bytes(2, "little")
        answer = self.send(packets.build(servo_id, packets.READ, question))[0]
        return int.from_bytes(answer.parameters[1:], "little", signed=register.signed)


def ready(chain=None):
    """A master whose servos have limits, a profile velocity and torque."""
    master = Master(chain or make_chain())
    for servo_id in range(1, 11):
        master.write(servo_id, "minimum_position_limit", LOWEST)
        master.write(servo_id, "maximum_position_limit", HIGHEST)
        master.write(servo_id, "profile_velocity", 100)
        master.write(servo_id, "torque_enable", 1)
    return master


def test_eeprom_is_locked_while_torque_is_on():
    master = ready()
    assert master.write(1, "operating_mode", 1) == ACCESS
    assert master.write(1, "torque_enable", 0) == 0
    assert master.write(1, "operating_mode", 3) == 0


def test_ranges_limits_lengths_and_read_only_items_are_refused():
    master = ready()
    assert master.write(1, "goal_position", HIGHEST) == 0
    assert master.write(1, "goal_position", HIGHEST + 1) == DATA_LIMIT
    assert master.write(1, "goal_position", -1) == DATA_LIMIT
    assert master.write(1, "torque_enable", 2) == DATA_RANGE
    assert master.write(1, "present_position", 5) == ACCESS
    (short,) = master.send(packets.build(1, packets.WRITE, bytes([116, 0, 1, 2])))
    assert short.parameters[0] == DATA_LENGTH
    assert master.read(1, "goal_position") == HIGHEST


def test_goal_is_reached_at_profile_velocity_and_not_faster():
    master = ready()
    master.write(1, "goal_position", HIGHEST)
    seconds = (HIGHEST - 2048) / (100 * TICKS_PER_S_PER_UNIT)
    started = master.now
    while master.now - started < seconds:
        before = master.read(1, "present_position")
        # one tick of rounding at either end
        assert master.read(1, "present_position") - before <= 100 * TICKS_PER_S_PER_UNIT * GAP_S + 2
    assert abs(master.read(1, "present_position") - HIGHEST) <= 1


def test_lag_behind_a_steady_profile_is_speed_times_time_constant():
    motion = Motion(0.0, XL430)
    motion.advance(1.0, 1e6, 100, 0, 12.0)
    speed = 100 * TICKS_PER_S_PER_UNIT
    # first-order lag under a ramp: exactly speed * LAG_S in continuous time; the step of 2 ms adds up to one step's way
    assert motion.profile - motion.position == pytest.approx(speed * LAG_S, abs=speed * 0.002)


def test_profile_acceleration_bounds_the_change_of_speed():
    motion, speeds = Motion(0.0, XL430), []
    for _ in range(800):
        motion.advance(0.002, 2000.0, 200, 100, 12.0)
        speeds.append(motion._profile_velocity)
    most = 100 * 214.577 * 4096 / 3600 * 0.002
    assert np.abs(np.diff(speeds[:100])).max() <= most * (1 + 1e-9)
    assert motion.position == pytest.approx(2000.0, abs=1.0)


def test_no_load_speed_at_low_voltage_bounds_an_unlimited_profile():
    motion = Motion(0.0, XL430)
    motion.advance(0.5, 1e6, 0, 0, 6.0)
    assert motion.position <= 30.5 * 4096 / 60 * 0.5


def test_watchdog_trips_stops_clears_profile_and_locks_goals_until_it_is_cleared():
    master = ready()
    master.write(1, "bus_watchdog", 10)
    master.write(1, "goal_position", HIGHEST)
    master.now += 1.0
    assert master.read(1, "bus_watchdog") == -1
    assert master.read(1, "profile_velocity") == 0
    stopped = master.read(1, "present_position")
    assert stopped < 2048 + 0.45 * 100 * TICKS_PER_S_PER_UNIT
    assert master.write(1, "goal_position", 2048) == DATA_RANGE
    assert master.read(1, "present_position") == stopped
    assert master.write(1, "bus_watchdog", 0) == 0
    assert master.write(1, "goal_position", 2048) == 0


def test_watchdog_is_fed_by_packets_to_its_own_servo_only():
    master = ready()
    master.write(1, "bus_watchdog", 10)
    for _ in range(5):
        master.read(2, "present_position")
    assert master.read(1, "bus_watchdog") == -1


def test_overheated_servo_switches_off_raises_its_alert_bit_and_stays_off_until_it_is_rebooted():
    master = ready()
    master.chain.servos[0].temperature = 90
    (answer,) = master.send(packets.build(1, packets.PING))
    assert answer.parameters[0] & 0x80
    assert master.read(1, "torque_enable") == 0
    master.chain.servos[0].temperature = 30
    assert master.write(1, "torque_enable", 1) != 0
    master.send(packets.build(1, packets.REBOOT))
    assert master.write(1, "torque_enable", 1) == 0


def test_answers_take_the_time_of_their_bytes_and_the_return_delay():
    chain = make_chain(baud_rate=57600)
    question = packets.build(1, packets.READ, bytes([132, 0, 4, 0]))
    (reply,) = chain.receive(question, 1.0)
    # 14 bytes asked, 15 answered, 10 bits each; factory return delay 250 * 2 us
    assert reply.due - 1.0 == pytest.approx((14 + 15) * 10 / 57600 + 500e-6, rel=1e-9)


def test_sync_read_is_silenced_behind_a_silent_servo():
    master = ready(make_chain(["silent:4@10"]))
    master.now += 10.0
    raw = packets.build(254, packets.SYNC_READ, bytes([132, 0, 4, 0, *range(1, 11)]))
    assert [p.id for p in master.send(raw)] == [1, 2, 3]


def test_reg_write_waits_for_action():
    master = ready()
    goal = bytes([116, 0]) + (2100).to_bytes(4, "little")
    master.send(packets.build(1, packets.REG_WRITE, goal))
    assert master.read(1, "goal_position") == 2048
    master.send(packets.build(1, packets.ACTION))
    assert master.read(1, "goal_position") == 2100


@pytest.mark.parametrize(
    "text", ["", "boom@1", "silent@1", "voltage:3@1", "silent:4", "crc:4@x", "silent:4@1=..", "crc:4@1.2.3"]
)
def test_misspelt_fault_is_refused(text):
    with pytest.raises(InputError, match="--fault"):
        parse_fault(text)


def corrupted(raw, source):
    """One of the ways in which a packet can arrive wrong."""
    at = source.randrange(len(raw))
    return [
        lambda: raw[:at] + bytes([raw[at] ^ 1 << source.randrange(8)]) + raw[at + 1 :],
        lambda: raw[:at],
        lambda: raw[at:],
        lambda: raw[::-1],
        lambda: raw + raw,
        lambda: raw[:at] + raw,
        lambda: raw[:at] + source.randbytes(source.randrange(1, 20)) + raw[at:],
        lambda: source.randbytes(source.randrange(1, 60)),
    ][source.randrange(8)]()


def goals_packet(source):
    goals = b"".join(bytes([i]) + source.randrange(LOWEST, HIGHEST).to_bytes(4, "little") for i in range(1, 11))
    return packets.build(254, packets.SYNC_WRITE, bytes([116, 0, 4, 0]) + goals)


def check_inside(chain):
    for servo in chain.servos:
        assert LOWEST - 0.5 <= servo.motion.position <= HIGHEST + 0.5
        # the position's steps of 2 ms behind a lag of 20 ms: half a step over the lag is 5 %
        assert servo.fastest <= 100 * TICKS_PER_S_PER_UNIT * 1.05


def test_5000_corrupt_packets_never_crash_and_never_drive_a_servo_out_of_its_limits():
    source, master = random.Random(3), ready()
    reads = packets.build(254, packets.SYNC_READ, bytes([126, 0, 21, 0, *range(1, 11)]))
    for _ in range(5000):
        master.now += source.choice([0.0005, 0.01, 0.06])
        raw = source.choice([goals_packet(source), goals_packet(source), reads])
        master.chain.receive(corrupted(raw, source), master.now)
        check_inside(master.chain)
    assert master.chain.parser.rejected > 1000
    assert master.read(1, "minimum_position_limit") == LOWEST


def test_3000_random_instructions_with_a_right_checksum_never_crash():
    """Nonsense that is well-formed: goals stay inside whatever limits the servo has."""
    source, master = random.Random(4), ready()
    for _ in range(3000):
        instruction = source.choice([1, 2, 3, 4, 5, 6, 8, 16, 0x55, 0x82, 0x83, 0x92, 0x93, source.randrange(256)])
        servo_id = source.choice([1, 2, 3, 254, source.randrange(253)])
        master.send(packets.build(servo_id, instruction, source.randbytes(source.randrange(0, 24))))
        for servo in master.chain.servos:
            table = servo.table
            if servo.torque and not table["bus_watchdog"] < 0:
                assert 0 <= table["present_position"] <= 4095


def test_a_fault_of_a_servo_that_is_not_there_is_refused():
    done = serpenoid("robot", "emulate", "--fault", "overheat:44@3")
    assert done.returncode == 2
    assert (
        "--fault overheat:44@3: no emulated servo has this ID; there are [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]" in done.stderr
    )
