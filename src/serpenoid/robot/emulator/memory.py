"""A servo's control table: what may be written, when, and within which limits."""

from __future__ import annotations

from serpenoid.robot.models import WATCHDOG_TRIPPED, Register, ServoModel

RESULT_FAIL, INSTRUCTION_ERROR, CRC_ERROR, DATA_RANGE, DATA_LENGTH, DATA_LIMIT, ACCESS = range(1, 8)
SIZE = 256
GOALS = ("goal_pwm", "goal_current", "goal_velocity", "goal_position")


class ControlTable:
    """Bytes with a model's rules: EEPROM locked while torque is on, ranges, limits, read-only goals after a trip."""

    def __init__(self, model: ServoModel, servo_id: int, baud_value: int) -> None:
        self._registers = model.registers
        self._by_address = {register.address: name for name, register in model.registers.items()}
        self._bytes = bytearray(SIZE)
        for name, register in self._registers.items():
            self[name] = register.initial
        self["id"] = servo_id
        self["baud_rate"] = baud_value

    def __getitem__(self, name: str) -> int:
        register = self._registers[name]
        return int.from_bytes(self._bytes[register.address : register.end], "little", signed=register.signed)

    def __setitem__(self, name: str, value: int) -> None:
        register = self._registers[name]
        data = (int(value) & (1 << 8 * register.size) - 1).to_bytes(register.size, "little")
        self._bytes[register.address : register.end] = data

    def read(self, address: int, size: int) -> tuple[int, bytes]:
        """(error, bytes)"""
        if size == 0 or address + size > SIZE:
            return ACCESS, b""
        return 0, bytes(self._bytes[address : address + size])

    def reset_ram(self) -> None:
        for name, register in self._registers.items():
            if not register.eeprom:
                self[name] = register.initial

    def write(self, address: int, data: bytes) -> int:
        """Check every register that is touched, then write them all or none; return the error number."""
        wanted: dict[str, int] = {}
        while data:
            name = self._by_address.get(address)
            if name is None:
                return ACCESS
            register = self._registers[name]
            if len(data) < register.size:
                return DATA_LENGTH
            wanted[name] = int.from_bytes(data[: register.size], "little", signed=register.signed)
            address, data = register.end, data[register.size :]
        for name, value in wanted.items():
            error = self._error(name, self._registers[name], value)
            if error:
                return error
        for name, value in wanted.items():
            self[name] = value
        return 0

    def _error(self, name: str, register: Register, value: int) -> int:
        if register.low is None or register.high is None:
            return ACCESS
        if register.eeprom and self["torque_enable"]:
            return ACCESS
        if not register.low <= value <= register.high:
            return DATA_RANGE
        if name == "bus_watchdog" and value < 0:
            return DATA_RANGE
        if name in GOALS and self["bus_watchdog"] == WATCHDOG_TRIPPED:
            return DATA_RANGE
        if name == "torque_enable" and value and self["hardware_error_status"] & self["shutdown"]:
            return RESULT_FAIL
        return self._limit_error(name, value)

    def _limit_error(self, name: str, value: int) -> int:
        if name == "goal_position":
            inside = self["minimum_position_limit"] <= value <= self["maximum_position_limit"]
        elif name in ("goal_velocity", "goal_current"):
            inside = abs(value) <= self[f"{name.removeprefix('goal_')}_limit"]
        else:
            inside = True
        return 0 if inside else DATA_LIMIT
