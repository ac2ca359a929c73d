"""What a servo says of itself, and how the bytes of its control table are read."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from serpenoid.robot.models import WATCHDOG_TRIPPED, Block, Register, ServoModel


@dataclass(frozen=True)
class ServoState:
    """One reading: position [ticks], voltage [V], temperature [deg C], the status packet's alert bit.

    effort: what its model tells of its motor (`models.Effort`): load [-1..1] or current [A].
    """

    position: int
    effort: float
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


def _unpack(data: bytes, block: Block, servo: ServoModel) -> Callable[[str], int]:
    """Registers by name out of a block that was read."""

    def value(name: str) -> int:
        register = servo.registers[name]
        return decode(data[register.address - block.address : register.end - block.address], register)

    return value


def decode_state(data: bytes, alert: bool, servo: ServoModel) -> ServoState:
    value = _unpack(data, servo.state, servo)
    return ServoState(
        position=value("present_position"),
        effort=value(servo.effort.register) * servo.effort.per_unit,
        voltage=value("present_input_voltage") * servo.volt_per_unit,
        temperature=value("present_temperature"),
        alert=alert,
    )


def decode_health(data: bytes, servo: ServoModel) -> ServoHealth:
    value = _unpack(data, servo.health, servo)
    tripped = value("bus_watchdog") == WATCHDOG_TRIPPED
    return ServoHealth(bool(value("torque_enable")), value("hardware_error_status"), tripped)
