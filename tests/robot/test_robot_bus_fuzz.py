"""The player's side of the bus against corrupt answers, without waiting: the real SDK on a port in memory."""

import contextlib
import random
from types import SimpleNamespace

import numpy as np
import pytest
from emulated import gait, make_chain, robot
from test_robot_emulator import corrupted

from serpenoid.robot import player as player_module
from serpenoid.robot import stop
from serpenoid.robot.bus import Bus, link
from serpenoid.robot.faults import BusFault, RobotFault
from serpenoid.robot.log import ServoLog
from serpenoid.robot.plan import make_plan
from serpenoid.robot.player import Player


class Clock:
    """Time that passes only when somebody waits."""

    def __init__(self):
        self.now = 0.0

    def monotonic(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds


class MemoryPort:
    """What pyserial offers, with a chain behind it; `spoil(bytes)` changes each answer."""

    def __init__(self, chain, clock, spoil, spoil_question=None):
        self.chain, self.clock, self.spoil = chain, clock, spoil
        self.spoil_question = spoil_question or (lambda raw: raw)
        self.arriving = []
        self.written = []

    def write(self, data):
        raw = bytes(data)
        self.written.append(raw)
        replies = self.chain.receive(self.spoil_question(raw), self.clock.now)
        self.arriving += [(reply.due, self.spoil(reply.data)) for reply in replies]
        return len(raw)

    def read(self, size):
        """Up to `size` bytes that have arrived; reading nothing takes a slice of time."""
        here = b"".join(data for due, data in self.arriving if due <= self.clock.now)
        self.arriving = [(due, data) for due, data in self.arriving if due > self.clock.now]
        if len(here) > size:
            self.arriving.insert(0, (0.0, here[size:]))
        if len(here) < size:
            self.clock.now += link.READ_SLICE_S
        return here[:size]

    def reset_input_buffer(self):
        self.arriving = [(due, data) for due, data in self.arriving if due > self.clock.now]

    def close(self):
        pass


@pytest.fixture
def rig(monkeypatch):
    """make(spoil) -> (bus, port, chain, clock)"""
    clock = Clock()
    for module in (link, player_module, stop):
        monkeypatch.setattr(module, "time", clock)

    def make(spoil, spoil_question=None):
        chain = make_chain()
        port = MemoryPort(chain, clock, spoil, spoil_question)
        monkeypatch.setattr(link, "serial", SimpleNamespace(Serial=lambda *_, **__: port))
        return Bus("memory", 1000000, robot().by_id), port, chain, clock

    return make


def test_honest_port_in_memory_works(rig):
    bus, _, _, _ = rig(lambda raw: raw)
    assert bus.ping(3) == 1060
    assert bus.read_states(range(1, 11))[10].position == 2048
    assert sorted(bus.scan().servos) == list(range(1, 11))


def test_3000_exchanges_with_corrupt_answers_raise_nothing_but_bus_faults(rig):
    source = random.Random(5)
    bus, _, chain, _ = rig(lambda raw: corrupted(raw, source) if source.random() < 0.5 else raw)
    faults = 0
    for k in range(1000):
        for exchange in (
            lambda k=k: bus.ping(k % 10 + 1),
            lambda: bus.read(1, "present_position"),
            lambda: bus.write(2, "goal_position", 2048),
        ):
            try:
                exchange()
            except BusFault:
                faults += 1
    assert sum(bus.failures.values()) > 300
    assert not any(servo.torque for servo in chain.servos)


def test_state_that_is_accepted_is_a_state_that_was_sent(rig):
    """A checksum of 16 bits passes one wrong packet in 65,536: none of these few hundred."""
    source = random.Random(6)
    bus, _, _, _ = rig(lambda raw: corrupted(raw, source) if source.random() < 0.2 else raw)
    for _ in range(100):
        try:
            states = bus.read_states(range(1, 11))
        except BusFault:
            continue
        assert sorted(states) == list(range(1, 11))
        assert {state.position for state in states.values()} == {2048}
        assert {state.temperature for state in states.values()} == {34}


def test_babbling_bus_is_noticed(rig):
    bus, port, _, clock = rig(lambda raw: raw)

    def babble(size):
        clock.now += 0.0001
        return b"\x55" * size

    port.read = babble
    with pytest.raises(BusFault, match="never falls silent"):
        bus.read(1, "present_position")


class NobodyStops:
    """A stop watcher in the memory port's time."""

    def __init__(self, clock):
        self.clock = clock

    def check(self):
        pass

    def wait_until(self, deadline):
        self.clock.now = max(self.clock.now, deadline)


@pytest.mark.parametrize("seed", range(12))
def test_player_on_a_corrupt_bus_keeps_the_limits_and_can_switch_off(rig, seed):
    """Questions and answers are corrupted at random while a whole trial is played."""
    source = random.Random(seed)
    share = source.choice([0.002, 0.01, 0.05])

    def spoil(raw):
        return corrupted(raw, source) if source.random() < share else raw

    bus, port, chain, clock = rig(spoil, spoil)
    plan = make_plan(gait(), robot(), 1.0, 2, 0.1)
    player = Player(bus, plan, ServoLog(None, robot()), NobodyStops(clock), lambda _: None)
    with contextlib.suppress(RobotFault):
        player.run()
    port.spoil_question = lambda raw: raw  # the packet that matters arrives
    bus.torque_off(robot().ids)
    assert not any(servo.torque for servo in chain.servos)
    for servo in chain.servos:
        assert 1138 <= servo.lowest <= servo.highest <= 2958
        # the joint's speed limit, 40 rpm: no corrupt packet made it faster
        assert servo.fastest <= 40.0 * 4096 / 60


def test_player_on_a_clean_bus_reaches_every_row_on_time(rig):
    bus, _, chain, clock = rig(lambda raw: raw)
    plan = make_plan(gait(), robot(), 1.0, 2, 0.1)
    player = Player(bus, plan, ServoLog(None, robot()), NobodyStops(clock), lambda _: None)
    player.run()
    # time passes only on the bus, and its packets fit into a row
    assert max(player.timing.lateness) < 1e-9
    assert np.allclose([servo.motion.position for servo in chain.servos], plan.ticks[0], atol=2)
