"""Servos that share an ID: their answers collide, and a scan says so and what to do."""

import random

import pytest
from emulated import interrupt, make_chain, start
from hypothesis import given
from hypothesis import strategies as st

from serpenoid.cli import robot_bus
from serpenoid.cli.main import main
from serpenoid.cli.robot_bus import LAST_ID
from serpenoid.robot.bus.collisions import read_ping_answers
from serpenoid.robot.emulator import packets
from serpenoid.robot.emulator.collision import overlapped


def answer(servo_id: int, model: int = 1060, firmware: int = 45) -> bytes:
    return packets.build_status(servo_id, 0, model.to_bytes(2, "little") + bytes([firmware]))


def checksum(data: bytes) -> int:
    return packets.crc16(data)


def test_one_answer_alone_passes_the_line_unchanged():
    assert overlapped([answer(3)], random.Random(0)) == answer(3)


@given(st.lists(st.integers(0, 252), unique=True, max_size=20), st.binary(max_size=30))
def test_whole_answers_are_read_whatever_stands_before_them(ids, rubbish):
    found = read_ping_answers(rubbish.replace(b"\xff", b"\xfe") + b"".join(map(answer, ids)), checksum)
    assert found.servos == {servo_id: (1060, 45) for servo_id in sorted(ids)}
    assert found.garbled == len(rubbish)


@given(st.binary(max_size=200))
def test_rubbish_is_no_servo(data):
    found = read_ping_answers(data, checksum)
    assert len(found.servos) * 14 + found.garbled <= len(data)


@pytest.mark.parametrize("seed", range(20))
def test_two_answers_at_once_are_no_whole_answer(seed):
    found = read_ping_answers(overlapped([answer(4), answer(4)], random.Random(seed)), checksum)
    assert found.servos == {}
    assert found.garbled > 0


def test_an_id_that_answers_twice_is_a_collision():
    assert read_ping_answers(answer(4) + answer(4), checksum).repeated == (4,)


def test_servos_with_one_id_all_obey_and_none_is_understood():
    chain = make_chain()
    for servo in chain.servos:
        servo.table["id"] = 1
    torque = packets.build(1, packets.WRITE, bytes([64, 0, 1]))
    (reply,) = chain.receive(torque, 1.0)
    assert all(servo.torque for servo in chain.servos)
    assert list(packets.Parser().feed(reply.data)) == []


@pytest.mark.usefixtures("serial_ports")
@pytest.mark.parametrize(  # every ID that is asked by itself takes 40 ms
    ("ids", "whole", "shared", "last"),
    [
        pytest.param("1,1,1,1,1,1,1,1,1,1", 0, [1], LAST_ID, marks=pytest.mark.slow),
        ("1,2,2,4,5,5,7,8,9,10", 6, [2, 5], 20),
    ],
)
def test_scan_names_the_ids_that_are_shared_and_the_remedy(ids, whole, shared, last, monkeypatch, capsys):
    monkeypatch.setattr(robot_bus, "LAST_ID", last)
    process = start("robot", "emulate", "--ids", ids)
    try:
        port = process.stdout.readline().strip()
        code = main(["robot", "scan", "--port", port, "--baud-rate", "1000000"])
    finally:
        interrupt(process)
    assert code == 1
    out, err = capsys.readouterr()
    assert out.count("XL430-W250-T") == whole
    garbled = "  1000000 baud  garbled: more than one servo has this ID"
    assert [int(line[2:6]) for line in err.splitlines() if line.endswith(garbled)] == shared
    assert "Leave one servo on the bus, give it its own ID" in err
