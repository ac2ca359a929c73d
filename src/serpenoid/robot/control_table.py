"""The XL430-W250-T's registers, units and published limits (ROBOTIS e-manual, XL430-W250, Protocol 2.0)."""

from __future__ import annotations

from dataclasses import dataclass

MODEL_NAME = "XL430-W250-T"
MODEL_NUMBER = 1060
OLDEST_FIRMWARE = 38  # the first with Bus Watchdog (98) and Protocol 2.0 as documented

TICKS_PER_TURN = 4096
RPM_PER_VELOCITY_UNIT = 0.229
RPM2_PER_ACCELERATION_UNIT = 214.577  # rev/min^2
VOLT_PER_UNIT = 0.1
LOAD_PER_UNIT = 0.001
WATCHDOG_UNIT_S = 0.020
WATCHDOG_TRIPPED = -1
POSITION_MODE = 3

# register value of Baud Rate (8) -> bits per second
BAUD_RATES = {0: 9600, 1: 57600, 2: 115200, 3: 1000000, 4: 2000000, 5: 3000000, 6: 4000000, 7: 4500000}

# bit of Hardware Error Status (70) -> what it is and what to do
HARDWARE_ERRORS = {
    0: ("input voltage out of its limits", "charge or replace the battery"),
    2: ("overheating", "let it cool; slow the gait down or lighten the load"),
    3: ("motor encoder", "the servo is damaged: replace it"),
    4: ("electrical shock, or too little power to drive the motor", "check wiring and battery"),
    5: ("overload", "free the joint; slow the gait down or lighten the load"),
}


@dataclass(frozen=True)
class Register:
    """One item of the control table; `low`..`high` is its absolute range (None: read only)."""

    address: int
    size: int
    initial: int = 0
    low: int | None = None
    high: int | None = None
    signed: bool = False

    @property
    def eeprom(self) -> bool:
        return self.address < 64

    @property
    def end(self) -> int:
        return self.address + self.size


def _rw(address: int, size: int, initial: int, low: int, high: int) -> Register:
    return Register(address, size, initial, low, high, signed=low < 0)


REGISTERS: dict[str, Register] = {
    "model_number": Register(0, 2, MODEL_NUMBER),
    "model_information": Register(2, 4),
    "firmware_version": Register(6, 1, 45),
    "id": _rw(7, 1, 1, 0, 252),
    "baud_rate": _rw(8, 1, 1, 0, 7),
    "return_delay_time": _rw(9, 1, 250, 0, 254),  # 2 us
    "drive_mode": _rw(10, 1, 0, 0, 13),
    "operating_mode": _rw(11, 1, 3, 0, 16),
    "secondary_id": _rw(12, 1, 255, 0, 255),
    "protocol_type": _rw(13, 1, 2, 1, 2),
    "homing_offset": _rw(20, 4, 0, -1044479, 1044479),
    "moving_threshold": _rw(24, 4, 10, 0, 1023),
    "temperature_limit": _rw(31, 1, 72, 0, 100),
    "maximum_voltage_limit": _rw(32, 2, 140, 60, 140),
    "minimum_voltage_limit": _rw(34, 2, 60, 60, 140),
    "pwm_limit": _rw(36, 2, 885, 0, 885),
    "velocity_limit": _rw(44, 4, 265, 0, 1023),
    "maximum_position_limit": _rw(48, 4, 4095, 0, 4095),
    "minimum_position_limit": _rw(52, 4, 0, 0, 4095),
    "startup_configuration": _rw(60, 1, 0, 0, 3),
    "shutdown": _rw(63, 1, 52, 0, 255),
    "torque_enable": _rw(64, 1, 0, 0, 1),
    "led": _rw(65, 1, 0, 0, 1),
    "status_return_level": _rw(68, 1, 2, 0, 2),
    "registered_instruction": Register(69, 1),
    "hardware_error_status": Register(70, 1),
    "velocity_i_gain": _rw(76, 2, 1000, 0, 16383),
    "velocity_p_gain": _rw(78, 2, 100, 0, 16383),
    "position_d_gain": _rw(80, 2, 4000, 0, 16383),
    "position_i_gain": _rw(82, 2, 0, 0, 16383),
    "position_p_gain": _rw(84, 2, 640, 0, 16383),
    "feedforward_2nd_gain": _rw(88, 2, 0, 0, 16383),
    "feedforward_1st_gain": _rw(90, 2, 0, 0, 16383),
    "bus_watchdog": _rw(98, 1, 0, -1, 127),
    "goal_pwm": _rw(100, 2, 885, -885, 885),
    "goal_velocity": _rw(104, 4, 0, -1023, 1023),
    "profile_acceleration": _rw(108, 4, 0, 0, 32767),
    "profile_velocity": _rw(112, 4, 0, 0, 32767),
    "goal_position": _rw(116, 4, 2048, -1048575, 1048575),
    "realtime_tick": Register(120, 2),
    "moving": Register(122, 1),
    "moving_status": Register(123, 1),
    "present_pwm": Register(124, 2, signed=True),
    "present_load": Register(126, 2, signed=True),
    "present_velocity": Register(128, 4, signed=True),
    "present_position": Register(132, 4, 2048, signed=True),
    "velocity_trajectory": Register(136, 4, signed=True),
    "position_trajectory": Register(140, 4, 2048, signed=True),
    "present_input_voltage": Register(144, 2, 118),
    "present_temperature": Register(146, 1, 34),
    "backup_ready": Register(147, 1),
}


def no_load_speed_rpm(voltage: float) -> float:
    """No-load speed [rpm] at `voltage` [V]: proportional to it through 61 rpm at 12 V.

    The published 57 rpm at 11.1 V and 47 rpm at 9.0 V lie 1 % and 3 % above this line, so it errs on the safe side.
    """
    return 61.0 * voltage / 12.0


def name_hardware_errors(bits: int) -> str:
    """`overheating (let it cool; ...) and overload (...)` for the bits of Hardware Error Status."""
    named = [f"{what} ({remedy})" for bit, (what, remedy) in HARDWARE_ERRORS.items() if bits >> bit & 1]
    return " and ".join(named) or f"unknown hardware error bits {bits:#04x}"
