"""Who answered a broadcast ping, and what came beside whole answers: two servos with one ID talk at once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

HEADER = b"\xff\xff\xfd\x00"
STATUS = 0x55
PING_ANSWER = 14  # bytes: header, ID, length, instruction, error, model, firmware, checksum

REMEDY = (
    "Two servos with one ID answer at once, and neither is understood. Leave one servo on the bus, give it its own ID "
    "(DYNAMIXEL Wizard 2.0), add the next one and scan again. Servos leave the factory with ID 1."
)


@dataclass(frozen=True)
class Found:
    """`servos`: ID -> (model number, firmware); `repeated`: IDs that answered twice; `garbled`: bytes of no answer."""

    servos: dict[int, tuple[int, int]]
    repeated: tuple[int, ...] = ()
    garbled: int = 0

    @property
    def collision(self) -> bool:
        """Whether something answered that could not be understood."""
        return bool(self.repeated or self.garbled)


def read_ping_answers(data: bytes, checksum: Callable[[bytes], int]) -> Found:
    """Everything that was heard after a broadcast ping; `checksum`: that of the protocol, of bytes."""
    servos: dict[int, tuple[int, int]] = {}
    answered: Counter[int] = Counter()
    at, whole = 0, 0
    while (at := data.find(HEADER, at)) >= 0:
        packet = data[at : at + PING_ANSWER]
        if _is_answer(packet, checksum):
            servos[packet[4]] = int.from_bytes(packet[9:11], "little"), packet[11]
            answered[packet[4]] += 1
            whole, at = whole + PING_ANSWER, at + PING_ANSWER
        else:
            at += len(HEADER)
    repeated = tuple(sorted(servo_id for servo_id, times in answered.items() if times > 1))
    return Found(dict(sorted(servos.items())), repeated, len(data) - whole)


def _is_answer(packet: bytes, checksum: Callable[[bytes], int]) -> bool:
    if len(packet) < PING_ANSWER or packet[5:8] != bytes([7, 0, STATUS]):
        return False
    return checksum(packet[:-2]) == int.from_bytes(packet[-2:], "little")
