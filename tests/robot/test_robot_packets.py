"""Packets against ROBOTIS's published examples (e-manual, DYNAMIXEL Protocol 2.0, "Instruction Details")."""

import random

import pytest
from dynamixel_sdk import Protocol2PacketHandler

from serpenoid.robot.emulator import packets

# (ID, instruction, parameters, the packet as published)
PUBLISHED_INSTRUCTIONS = {
    "ping": (1, packets.PING, "", "FF FF FD 00 01 03 00 01 19 4E"),
    "broadcast ping": (254, packets.PING, "", "FF FF FD 00 FE 03 00 01 31 42"),
    "read": (1, packets.READ, "84 00 04 00", "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15"),
    "write": (1, packets.WRITE, "74 00 00 02 00 00", "FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89"),
    "reg write": (1, packets.REG_WRITE, "68 00 C8 00 00 00", "FF FF FD 00 01 09 00 04 68 00 C8 00 00 00 AE 8E"),
    "action": (1, packets.ACTION, "", "FF FF FD 00 01 03 00 05 02 CE"),
    "factory reset": (1, packets.FACTORY_RESET, "01", "FF FF FD 00 01 04 00 06 01 A1 E6"),
    "reboot": (1, packets.REBOOT, "", "FF FF FD 00 01 03 00 08 2F 4E"),
    "clear": (1, packets.CLEAR, "01 44 58 4C 22", "FF FF FD 00 01 08 00 10 01 44 58 4C 22 B1 DC"),
    "sync read": (254, packets.SYNC_READ, "84 00 04 00 01 02", "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA"),
    "sync write": (
        254,
        packets.SYNC_WRITE,
        "74 00 04 00 01 96 00 00 00 02 AA 00 00 00",
        "FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87",
    ),
    "bulk read": (
        254,
        packets.BULK_READ,
        "01 90 00 02 00 02 92 00 01 00",
        "FF FF FD 00 FE 0D 00 92 01 90 00 02 00 02 92 00 01 00 1A 05",
    ),
}
PUBLISHED_ANSWERS = {
    "ping 1": (1, "06 04 26", "FF FF FD 00 01 07 00 55 00 06 04 26 65 5D"),
    "ping 2": (2, "06 04 26", "FF FF FD 00 02 07 00 55 00 06 04 26 6F 6D"),
    "read 1": (1, "A6 00 00 00", "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0"),
    "read 2": (2, "1F 08 00 00", "FF FF FD 00 02 08 00 55 00 1F 08 00 00 BA BE"),
    "write": (1, "", "FF FF FD 00 01 04 00 55 00 A1 0C"),
    "bulk 1": (1, "77 00", "FF FF FD 00 01 06 00 55 00 77 00 C3 69"),
    "bulk 2": (2, "24", "FF FF FD 00 02 05 00 55 00 24 8B A9"),
}


@pytest.mark.parametrize("name", PUBLISHED_INSTRUCTIONS)
def test_instruction_is_as_published_both_ways(name):
    servo_id, instruction, parameters, published = PUBLISHED_INSTRUCTIONS[name]
    raw = bytes.fromhex(published)
    assert packets.build(servo_id, instruction, bytes.fromhex(parameters)) == raw
    (packet,) = packets.Parser().feed(raw)
    assert (packet.id, packet.instruction, packet.parameters) == (servo_id, instruction, bytes.fromhex(parameters))


@pytest.mark.parametrize("name", PUBLISHED_ANSWERS)
def test_status_packet_is_as_published(name):
    servo_id, data, published = PUBLISHED_ANSWERS[name]
    assert packets.build_status(servo_id, 0, bytes.fromhex(data)) == bytes.fromhex(published)


def test_checksum_agrees_with_the_sdk_on_random_bytes():
    source, sdk = random.Random(1), Protocol2PacketHandler()
    for _ in range(200):
        data = source.randbytes(source.randrange(1, 80))
        assert packets.crc16(data) == sdk.updateCRC(0, data, len(data))


def test_header_inside_parameters_is_stuffed_and_restored():
    parameters = bytes.fromhex("74 00 FF FF FD 00 FF FF FD FD")
    raw = packets.build(1, packets.WRITE, parameters)
    assert raw.count(packets.HEADER) == 1
    (packet,) = packets.Parser().feed(raw)
    assert packet.parameters == parameters


def test_parser_finds_packets_between_rubbish_in_any_chunks():
    source = random.Random(2)
    wanted = [packets.build(i, packets.READ, bytes([132, 0, 4, 0])) for i in range(1, 60)]
    rubbish = [bytes(b for b in source.randbytes(source.randrange(12)) if b != 0xFF) for _ in wanted]
    stream = b"".join(a + b for a, b in zip(rubbish, wanted, strict=True))
    parser, found = packets.Parser(), []
    while stream:
        size = source.randrange(1, 9)
        found += parser.feed(stream[:size])
        stream = stream[size:]
    assert [packet.id for packet in found] == list(range(1, 60))


def test_packet_after_a_broken_one_is_found():
    broken = bytearray(packets.build(1, packets.READ, bytes([132, 0, 4, 0])))
    broken[9] ^= 0x10
    parser = packets.Parser()
    found = list(parser.feed(bytes(broken) + packets.build(2, packets.PING)))
    assert [packet.id for packet in found] == [2]
    assert parser.rejected == 1
