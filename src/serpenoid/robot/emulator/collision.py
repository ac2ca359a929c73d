"""Two servos with one ID answer at once: on a shared line a low bit wins over a high one, and neither is understood."""

from __future__ import annotations

import random
from collections.abc import Sequence

MOST_SKEW = 40  # bits: no two servos begin to answer at the same moment


def overlapped(answers: Sequence[bytes], random_: random.Random) -> bytes:
    """What a receiver makes of several answers on one line, each begun a few bits after the first one."""
    lines = [[1] * (n and random_.randint(1, MOST_SKEW)) + _line(answer) for n, answer in enumerate(answers)]
    length = max(map(len, lines))
    together = [min(bits) for bits in zip(*(line + [1] * (length - len(line)) for line in lines), strict=True)]
    return _received(together)


def _line(data: bytes) -> list[int]:
    """Bits on the line: start bit, eight data bits from the lowest, stop bit."""
    return [bit for byte in data for bit in (0, *((byte >> k) & 1 for k in range(8)), 1)]


def _received(line: list[int]) -> bytes:
    """A receiver waits for a start bit and takes the eight bits behind it, whatever they are."""
    data, at = bytearray(), 0
    while at + 9 < len(line):
        if line[at] == 1:
            at += 1
            continue
        data.append(sum(bit << k for k, bit in enumerate(line[at + 1 : at + 9])))
        at += 10
    return bytes(data)
