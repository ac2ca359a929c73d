"""One emulated servo: its control table, its shaft, its watchdog and its protection."""

from __future__ import annotations

from math import copysign

from serpenoid.robot.emulator import packets
from serpenoid.robot.emulator.memory import ACCESS, INSTRUCTION_ERROR, ControlTable
from serpenoid.robot.emulator.motion import Motion
from serpenoid.robot.models import WATCHDOG_TRIPPED, ServoModel

SAG = 0.0231348  # of the voltage that a motor turns at: a battery gives way a little under load (0.2 V at 44 rpm)
ROOM_TEMPERATURE = 34
OVERVOLTAGE_BIT, OVERHEAT_BIT = 0x01, 0x04


class EmulatedServo:
    """Answers instructions and moves; `advance(now)` must be called before each instruction."""

    def __init__(self, model: ServoModel, servo_id: int, baud_value: int, position: float = 2048.0) -> None:
        self.model = model
        self.table = ControlTable(model, servo_id, baud_value)
        self.motion = Motion(position, model)
        self.supply_voltage = self.table["present_input_voltage"] * model.volt_per_unit
        self.temperature = ROOM_TEMPERATURE
        self.lowest = self.highest = position  # where the shaft has been while it was driven
        self.fastest = 0.0  # [ticks/s]
        self._now: float | None = None
        self._last_heard = 0.0
        self._registered: tuple[int, bytes] | None = None
        self._publish()

    @property
    def id(self) -> int:
        return self.table["id"]

    @property
    def torque(self) -> bool:
        return bool(self.table["torque_enable"])

    def hear(self, now: float) -> None:
        """Any instruction on the bus feeds the watchdog."""
        self._last_heard = now

    def advance(self, now: float) -> None:
        """Move, watch the bus and protect itself up to time `now` [s]."""
        duration = 0.0 if self._now is None else max(0.0, now - self._now)
        self._now = now
        table = self.table
        watchdog = table["bus_watchdog"]
        patience = watchdog * self.model.watchdog_unit_s
        if self.torque and watchdog > 0 and now - self._last_heard > patience:
            self._drive(max(0.0, duration - (now - self._last_heard - patience)))
            self._trip()
        elif self.torque and watchdog != WATCHDOG_TRIPPED:
            self._drive(duration)
        else:
            self.motion.rest()
        self._protect()
        self._publish()

    def execute(self, packet: packets.Packet) -> bytes | None:
        """Answer one instruction that is addressed to this servo alone (None: it is not to answer)."""
        handlers = {
            packets.PING: self._ping,
            packets.READ: self._read,
            packets.WRITE: self._write,
            packets.REG_WRITE: self._reg_write,
            packets.ACTION: self._action,
            packets.REBOOT: self._reboot,
            packets.CLEAR: self._clear,
        }
        handler = handlers.get(packet.instruction)
        error, data = handler(packet.parameters) if handler else (INSTRUCTION_ERROR, b"")
        level = self.table["status_return_level"]
        if packet.instruction == packets.PING or level == 2 or (level == 1 and packet.instruction == packets.READ):
            return self.status(error, data)
        return None

    def status(self, error: int, data: bytes = b"") -> bytes:
        alert = 0x80 if self.table["hardware_error_status"] else 0
        return packets.build_status(self.id, error | alert, data)

    def read_status(self, address: int, size: int) -> bytes:
        return self.status(*self.table.read(address, size))

    def write(self, address: int, data: bytes) -> int:
        before = self.torque
        error = self.table.write(address, data)
        if self.torque and not before:
            self.motion.rest()
            self._remember_range()
        if before and not self.torque and self.table["bus_watchdog"] == WATCHDOG_TRIPPED:
            self.table["profile_velocity"] = self.table["profile_acceleration"] = 0
        return error

    def reset(self) -> None:
        """RAM returns to its initial values; EEPROM and the shaft stay."""
        self.table.reset_ram()
        self._registered = None
        self.motion.rest()
        self._protect()

    def _drive(self, duration: float) -> None:
        table = self.table
        profile = table["profile_velocity"], table["profile_acceleration"]
        self.motion.advance(duration, table["goal_position"], *profile, self.supply_voltage)
        self._remember_range()
        self.fastest = max(self.fastest, abs(self.motion.velocity))

    def _remember_range(self) -> None:
        self.lowest = min(self.lowest, self.motion.position)
        self.highest = max(self.highest, self.motion.position)

    def _trip(self) -> None:
        """Bus Watchdog: stop, forget the profile, refuse goals until 0 is written to the watchdog."""
        self.table["bus_watchdog"] = WATCHDOG_TRIPPED
        self.table["profile_velocity"] = self.table["profile_acceleration"] = 0
        self.motion.rest()

    def _protect(self) -> None:
        table = self.table
        status = table["hardware_error_status"]
        if self.temperature > table["temperature_limit"]:
            status |= OVERHEAT_BIT
        low, high = (table[f"{end}_voltage_limit"] * self.model.volt_per_unit for end in ("minimum", "maximum"))
        if not low <= self.supply_voltage <= high:
            status |= OVERVOLTAGE_BIT
        table["hardware_error_status"] = status
        if status & table["shutdown"]:
            table["torque_enable"] = 0

    def _publish(self) -> None:
        table, motion, effort = self.table, self.motion, self.model.effort
        error = motion.profile - motion.position
        table["present_position"] = round(motion.position)
        table["present_velocity"] = round(motion.velocity / motion.per_unit)
        load = copysign(min(1.0, abs(error) / 200.0), error) if self.torque else 0.0
        table[effort.register] = round(load * effort.full / effort.per_unit)
        table["moving"] = int(abs(motion.velocity) > table["moving_threshold"] * motion.per_unit)
        turned_at = abs(motion.velocity) / motion.per_rpm / self.model.no_load_speed_rpm(1.0)  # [V]
        voltage = self.supply_voltage - SAG * turned_at
        table["present_input_voltage"] = round(voltage / self.model.volt_per_unit)
        table["present_temperature"] = round(self.temperature)
        table["position_trajectory"] = round(motion.profile)
        table["realtime_tick"] = int((self._now or 0.0) * 1000) % 32768

    def _ping(self, _: bytes) -> tuple[int, bytes]:
        return 0, self.table.read(0, 2)[1] + self.table.read(6, 1)[1]

    def _read(self, parameters: bytes) -> tuple[int, bytes]:
        if len(parameters) != 4:
            return INSTRUCTION_ERROR, b""
        return self.table.read(int.from_bytes(parameters[:2], "little"), int.from_bytes(parameters[2:], "little"))

    def _write(self, parameters: bytes) -> tuple[int, bytes]:
        if len(parameters) < 3:
            return INSTRUCTION_ERROR, b""
        return self.write(int.from_bytes(parameters[:2], "little"), parameters[2:]), b""

    def _reg_write(self, parameters: bytes) -> tuple[int, bytes]:
        if len(parameters) < 3:
            return INSTRUCTION_ERROR, b""
        self._registered = int.from_bytes(parameters[:2], "little"), parameters[2:]
        self.table["registered_instruction"] = 1
        return 0, b""

    def _action(self, _: bytes) -> tuple[int, bytes]:
        if self._registered is None:
            return INSTRUCTION_ERROR, b""
        registered, self._registered = self._registered, None
        self.table["registered_instruction"] = 0
        return self.write(*registered), b""

    def _reboot(self, _: bytes) -> tuple[int, bytes]:
        self.reset()
        return 0, b""

    def _clear(self, _: bytes) -> tuple[int, bytes]:
        return ACCESS, b""
