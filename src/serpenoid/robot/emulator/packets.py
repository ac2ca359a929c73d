"""Protocol 2.0 packets (ROBOTIS e-manual, DYNAMIXEL Protocol 2.0): header, stuffing, CRC-16.

    FF FF FD 00 | ID | length L, H | instruction | parameters ... | CRC L, H      length = parameters + 3

A status packet's first parameter is its error byte. The CRC is CRC-16/BUYPASS: polynomial 0x8005, start 0.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

HEADER = b"\xff\xff\xfd\x00"
BROADCAST = 0xFE
STATUS = 0x55
PING, READ, WRITE, REG_WRITE, ACTION, FACTORY_RESET, REBOOT, CLEAR = 0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x08, 0x10
SYNC_READ, SYNC_WRITE, BULK_READ, BULK_WRITE = 0x82, 0x83, 0x92, 0x93
LONGEST = 1024  # bytes after the length field; longer claims are noise


@dataclass(frozen=True)
class Packet:
    """One packet with its stuffing removed; `size` is its length on the wire."""

    id: int
    instruction: int
    parameters: bytes
    size: int = 0


def _crc_entry(byte: int) -> int:
    value = byte << 8
    for _ in range(8):
        value = (value << 1 ^ 0x8005 if value & 0x8000 else value << 1) & 0xFFFF
    return value


_CRC_TABLE = [_crc_entry(byte) for byte in range(256)]


def crc16(data: bytes) -> int:
    value = 0
    for byte in data:
        value = (value << 8 & 0xFFFF) ^ _CRC_TABLE[value >> 8 ^ byte]
    return value


def build(servo_id: int, instruction: int, parameters: bytes = b"") -> bytes:
    """A whole packet, stuffed, with its CRC."""
    body = _stuff(bytes([instruction]) + parameters)
    start = HEADER + bytes([servo_id]) + (len(body) + 2).to_bytes(2, "little") + body
    return start + crc16(start).to_bytes(2, "little")


def build_status(servo_id: int, error: int, parameters: bytes) -> bytes:
    return build(servo_id, STATUS, bytes([error]) + parameters)


class Parser:
    """Finds packets in a stream of bytes, whatever is between them; `rejected` counts what looked like one."""

    def __init__(self) -> None:
        self._buffer = bytearray()
        self.rejected = 0

    def feed(self, data: bytes) -> Iterator[Packet]:
        self._buffer += data
        while (packet := self._next()) is not None:
            yield packet

    def forget_partial(self) -> None:
        """The line fell silent inside a packet: give it up, as a servo does. Whole packets within are lost too."""
        if self._buffer:
            self.rejected += 1
            self._buffer.clear()

    def _next(self) -> Packet | None:
        while True:
            start = self._buffer.find(HEADER)
            if start < 0:
                del self._buffer[: max(0, len(self._buffer) - len(HEADER) + 1)]
                return None
            del self._buffer[:start]
            if len(self._buffer) < 7:
                return None
            length = int.from_bytes(self._buffer[5:7], "little")
            if not 3 <= length <= LONGEST or self._buffer[4] in (0xFD, 0xFF):
                self._reject()
            elif len(self._buffer) < 7 + length:
                return None
            elif (packet := self._take(7 + length)) is not None:
                return packet

    def _take(self, size: int) -> Packet | None:
        raw = bytes(self._buffer[:size])
        if crc16(raw[:-2]) != int.from_bytes(raw[-2:], "little"):
            self._reject()
            return None
        del self._buffer[:size]
        body = raw[7:-2].replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")
        return Packet(raw[4], body[0], body[1:], size)

    def _reject(self) -> None:
        """Skip this header and look for the next one behind it."""
        self.rejected += 1
        del self._buffer[:3]


def _stuff(body: bytes) -> bytes:
    return body.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
