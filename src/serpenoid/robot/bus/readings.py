"""What a servo says of itself, and how the bytes of its control table are read."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from serpenoid.robot.control_table import LOAD_PER_UNIT, REGISTERS, VOLT_PER_UNIT, WATCHDOG_TRIPPED, Register

FIRST_STATE = REGISTERS["present_load"]
STATE_BYTES = REGISTERS["present_temperature"].end - FIRST_STATE.address
FIRST_HEALTH = REGISTERS["torque_enable"]
HEALTH_BYTES = REGISTERS["bus_watchdog"].end - FIRST_HEALTH.address


@dataclass(frozen=True)
class ServoState:
    """One reading: load [-1..1], position [ticks], voltage [V], temperature [deg C], the status packet's alert bit."""

    position: int
    load: float
    voltage: float
    temperature: int
    alert: bool


@dataclass(frozen=True)
class ServoHealth:
    """What a servo says of itself: is the motor on, hardware error bits, has its bus watchdog tripped."""

    torque: bool
    hardware_error: int
    watchdog_tripped: bool


@dataclass(frozen=True)
class Answer:
    """A status packet's data, or the reason why there is none."""

    servo_id: int | None
    data: bytes = b""
    alert: bool = False
    reason: str = ""


def decode(data: bytes, item: Register) -> int:
    return int.from_bytes(data, "little", signed=item.signed)


def _unpack(data: bytes, start: int) -> Callable[[str], int]:
    """Registers by name out of a block that was read from address `start`."""

    def value(name: str) -> int:
        register = REGISTERS[name]
        return decode(data[register.address - start : register.end - start], register)

    return value


def decode_state(data: bytes, alert: bool) -> ServoState:
    value = _unpack(data, FIRST_STATE.address)
    return ServoState(
        position=value("present_position"),
        load=value("present_load") * LOAD_PER_UNIT,
        voltage=value("present_input_voltage") * VOLT_PER_UNIT,
        temperature=value("present_temperature"),
        alert=alert,
    )


def decode_health(data: bytes) -> ServoHealth:
    value = _unpack(data, FIRST_HEALTH.address)
    tripped = value("bus_watchdog") == WATCHDOG_TRIPPED
    return ServoHealth(bool(value("torque_enable")), value("hardware_error_status"), tripped)
