"""Serial ports: find the robot's, and make sure that one process alone talks to it."""

from __future__ import annotations

import os
from contextlib import AbstractContextManager
from pathlib import Path

from serial.tools import list_ports

from serpenoid.errors import InputError
from serpenoid.files.alone import alone

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


def exclusive_port(port: str) -> AbstractContextManager[None]:
    """Hold the port for this process; raise InputError at once if another serpenoid holds it."""
    remedy = "Stop the other one (or wait for it): two masters on one bus corrupt each other's packets."
    return alone("port", port, f"{port}: another serpenoid process is using this port. {remedy}")


def _list_ports() -> str:
    names = [f"{port.device} ({port.description})" for port in list_ports.comports()]
    return f"Ports here: {', '.join(names)}." if names else "This computer sees no serial ports; is the cable in?"
