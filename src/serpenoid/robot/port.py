"""Serial ports: find the robot's, and say why one cannot be opened."""

from __future__ import annotations

import errno
import os
from pathlib import Path

from serial.tools import list_ports

from serpenoid.errors import InputError

# USB vendor IDs of the usual adapters: ROBOTIS (OpenRB-150) and FTDI (U2D2)
KNOWN_VENDORS = {0x2F5D: "ROBOTIS", 0x0403: "FTDI"}


def resolve_port(name: str) -> str:
    """`auto` -> the one known adapter that is plugged in; any other name must exist."""
    if name != "auto":
        if os.name == "posix" and not Path(name).exists():
            raise InputError(f"--port {name}: no such port. {_list_ports()}")
        return name
    found = [port.device for port in list_ports.comports() if port.vid in KNOWN_VENDORS]
    if len(found) == 1:
        return found[0]
    if not found:
        raise InputError(f"--port auto: no OpenRB-150 or U2D2 is plugged in. {_list_ports()}")
    raise InputError(f"--port auto: several adapters are plugged in ({', '.join(found)}). Name one with --port.")


def not_opened(named: str, error: BaseException) -> InputError:
    """Why the port that `named` says (`--port /dev/ttyACM0`) cannot be opened.

    Ports are opened with the system's own lock of their device (`exclusive` of pyserial), which ends with the process
    that holds it, whoever that belongs to: nothing is left that could keep `robot off` from the bus.
    """
    if getattr(error, "errno", None) == errno.EWOULDBLOCK:
        return InputError(
            f"{named}: another program is using this port. Stop it, or wait for its end: two masters on one bus "
            "corrupt each other's packets."
        )
    said = error.args[-1] if error.args else error  # systems and terminals put a number before their words
    remedy = "Is it the right port, free, and may you use it (Linux: group dialout)?"
    return InputError(f"{named}: cannot be opened ({said}). {remedy}")


def _list_ports() -> str:
    names = [f"{port.device} ({port.description})" for port in list_ports.comports()]
    return f"Ports here: {', '.join(names)}." if names else "This computer sees no serial ports; is the cable in?"
