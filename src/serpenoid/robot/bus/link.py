"""The SDK's port with a monotonic clock, reads that sleep, and an end to babble.

The SDK times out on the wall clock, polls without sleeping, and reads on as long as bytes keep coming.
Of `dynamixel_sdk`, this file knows the port; `bus.py` beside it knows the packets.
"""

from __future__ import annotations

import time

import serial
from dynamixel_sdk import PortHandler

from serpenoid.robot.faults import BusFault

try:  # what a port raises when its cable is out: on POSIX also an error that is no OSError
    import termios

    PORT_ERRORS: tuple[type[BaseException], ...] = (serial.SerialException, OSError, termios.error)
except ImportError:
    PORT_ERRORS = (serial.SerialException, OSError)

READ_SLICE_S = 0.002  # a read sleeps this long for its bytes before the SDK looks at its own timeout
LONGEST_EXCHANGE = 5000  # bytes; a broadcast ping that all 253 IDs answer has 3542


def said(error: BaseException) -> str:
    """Its words: systems and terminals put a number before them."""
    return str(error.args[-1] if error.args else error)


class SerialLink(PortHandler):
    """A PortHandler whose port this process has alone."""

    def __init__(self, port_name: str) -> None:
        super().__init__(port_name)
        self._received = 0
        self.heard = bytearray()  # since the last question

    def getCurrentTime(self) -> float:  # noqa: N802 (the SDK's name)
        return time.monotonic() * 1000.0

    def setupPort(self, cflag_baud: int) -> bool:  # noqa: N802
        """Open it. Who comes second is refused before the baud rate is set or a byte is thrown away."""
        self.ser = serial.Serial(self.port_name, cflag_baud, timeout=READ_SLICE_S, write_timeout=0.5, exclusive=True)
        self.is_open = True
        self.tx_time_per_byte = 10 * 1000.0 / cflag_baud  # ten bits [ms]
        return True

    def setPacketTimeout(self, packet_length: int) -> None:  # noqa: N802
        super().setPacketTimeout(packet_length)
        self._forget()

    def setPacketTimeoutMillis(self, msec: float) -> None:  # noqa: N802
        super().setPacketTimeoutMillis(msec)
        self._forget()

    def _forget(self) -> None:
        self._received = 0
        self.heard.clear()

    def readPort(self, length: int) -> bytes:  # noqa: N802
        data: bytes = self.ser.read(length) if length > 0 else b""
        self._received += len(data)
        self.heard += data
        if self._received > LONGEST_EXCHANGE:
            raise BusFault("the bus never falls silent: another master, a wrong baud rate, or noise on the line.")
        return data
