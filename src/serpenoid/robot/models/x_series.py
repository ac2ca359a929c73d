"""What servos of the X series, and of the MX series with firmware of Protocol 2.0, have in common.

Source: ROBOTIS e-manual (github.com/ROBOTIS-GIT/emanual), the control tables of the pages that each model's file
names; addresses and sizes are those of ROBOTIS's dynamixel_hardware_interface (param/dxl_model/*.model), too. In the
e-manual's _includes/en/dxl/ stand hardware errors (control_table_shutdown.md), what a gain is
(control_table_position_pid_gain.md), the watchdog and the first firmware that has it (control_table_buswatchdog.md) and
baud rates (control_table_baudrate_2.md).
Firmware version, voltage and temperature are what the emulator's servos read at rest; no source gives them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from serpenoid.robot.models.servo_model import Effort, Register, ServoModel

FIRST_WITH_WATCHDOG = 38  # firmware
Registers = dict[str, Register]

BAUD_RATES = {0: 9600, 1: 57600, 2: 115200, 3: 1000000, 4: 2000000, 5: 3000000, 6: 4000000, 7: 4500000}
BAUD_RATES_330 = {code: rate for code, rate in BAUD_RATES.items() if code < 7}

MX_LACKS = "startup_configuration", "backup_ready"

HARDWARE_ERRORS = {
    0: ("input voltage out of its limits", "charge or replace the battery"),
    2: ("overheating", "let it cool; slow the gait down or lighten the load"),
    3: ("motor encoder", "the servo is damaged: replace it"),
    4: ("electrical shock, or too little power to drive the motor", "check wiring and battery"),
    5: ("overload", "free the joint; slow the gait down or lighten the load"),
}


def writable(address: int, size: int, initial: int, low: int, high: int) -> Register:
    return Register(address, size, initial, low, high, signed=low < 0)


COMMON: Registers = {
    "model_number": Register(0, 2),
    "model_information": Register(2, 4),
    "firmware_version": Register(6, 1, 45),
    "id": writable(7, 1, 1, 0, 252),
    "baud_rate": writable(8, 1, 1, 0, 7),
    "return_delay_time": writable(9, 1, 250, 0, 254),  # 2 us
    "drive_mode": writable(10, 1, 0, 0, 5),
    "operating_mode": writable(11, 1, 3, 0, 16),
    "secondary_id": writable(12, 1, 255, 0, 255),
    "protocol_type": writable(13, 1, 2, 1, 2),
    "homing_offset": writable(20, 4, 0, -1044479, 1044479),
    "moving_threshold": writable(24, 4, 10, 0, 1023),
    "temperature_limit": writable(31, 1, 80, 0, 100),
    "pwm_limit": writable(36, 2, 885, 0, 885),
    "velocity_limit": writable(44, 4, 0, 0, 1023),
    "maximum_position_limit": writable(48, 4, 4095, 0, 4095),
    "minimum_position_limit": writable(52, 4, 0, 0, 4095),
    "startup_configuration": writable(60, 1, 0, 0, 3),
    "shutdown": writable(63, 1, 52, 0, 255),
    "torque_enable": writable(64, 1, 0, 0, 1),
    "led": writable(65, 1, 0, 0, 1),
    "status_return_level": writable(68, 1, 2, 0, 2),
    "registered_instruction": Register(69, 1),
    "hardware_error_status": Register(70, 1),
    "velocity_i_gain": writable(76, 2, 1920, 0, 16383),
    "velocity_p_gain": writable(78, 2, 100, 0, 16383),
    "position_d_gain": writable(80, 2, 0, 0, 16383),
    "position_i_gain": writable(82, 2, 0, 0, 16383),
    "position_p_gain": writable(84, 2, 0, 0, 16383),
    "feedforward_2nd_gain": writable(88, 2, 0, 0, 16383),
    "feedforward_1st_gain": writable(90, 2, 0, 0, 16383),
    "bus_watchdog": writable(98, 1, 0, -1, 127),
    "goal_pwm": writable(100, 2, 885, -885, 885),
    "goal_velocity": writable(104, 4, 0, -1023, 1023),
    "profile_acceleration": writable(108, 4, 0, 0, 32767),
    "profile_velocity": writable(112, 4, 0, 0, 32767),
    "goal_position": writable(116, 4, 2048, -1048575, 1048575),
    "realtime_tick": Register(120, 2),
    "moving": Register(122, 1),
    "moving_status": Register(123, 1),
    "present_pwm": Register(124, 2, signed=True),
    "present_velocity": Register(128, 4, signed=True),
    "present_position": Register(132, 4, 2048, signed=True),
    "velocity_trajectory": Register(136, 4, signed=True),
    "position_trajectory": Register(140, 4, 2048, signed=True),
    "present_input_voltage": Register(144, 2),
    "present_temperature": Register(146, 1, 34),
    "backup_ready": Register(147, 1),
}


def voltage_limits(low: int, high: int) -> Registers:
    """Min and Max Voltage Limit [0.1 V] at the ends of their range; the servo leaves the factory with them."""
    return {
        "maximum_voltage_limit": writable(32, 2, high, low, high),
        "minimum_voltage_limit": writable(34, 2, low, low, high),
    }


def voltage_limits_330() -> Registers:
    """The same of the 330 series for 5 V: 3.1 to 7.0 V, from the factory 3.5 to 7.0 V."""
    return {
        "maximum_voltage_limit": writable(32, 2, 70, 31, 70),
        "minimum_voltage_limit": writable(34, 2, 35, 31, 70),
    }


def series_330(velocity_limit: int, pwm_slope: int = 140) -> Registers:
    """What the 330 series has beside or unlike the others: 4 Mbps at most, other protocols, faster motors."""
    return {
        "baud_rate": writable(8, 1, 1, 0, 6),
        "protocol_type": writable(13, 1, 2, 2, 22),
        "velocity_limit": writable(44, 4, velocity_limit, 0, 2047),
        "pwm_slope": writable(62, 1, pwm_slope, 1, 255),
        "goal_velocity": writable(104, 4, 0, -2047, 2047),
    }


def mx_series() -> Registers:
    """What the MX series with firmware of Protocol 2.0 has beside the others; it has none of `MX_LACKS`."""
    return voltage_limits(95, 160) | {"acceleration_limit": writable(40, 4, 32767, 0, 32767)}


def load() -> tuple[Effort, Registers]:
    """A servo that tells its load, 0.1 % of its full output, and measures no current."""
    return Effort("present_load", "load", 0.001, 1.0), {"present_load": Register(126, 2, signed=True)}


def current(unit_A: float, limit: int, stall_A: float) -> tuple[Effort, Registers]:
    """A servo that measures its motor's current: A per unit, Current Limit (38) [units], published current at stall."""
    return Effort("present_current", "current", unit_A, stall_A), {
        "current_limit": writable(38, 2, limit, 0, limit),
        "goal_current": writable(102, 2, limit, -limit, limit),
        "present_current": Register(126, 2, signed=True),
    }


def supply_current(limit_mA: int, stall_A: float) -> tuple[Effort, Registers]:
    """One of the 330 series, which measures what it draws from its supply, in mA (Current Limit's note on its page)."""
    effort, registers = current(0.001, limit_mA, stall_A)
    return replace(effort, column="supply_current"), registers


def servo(
    *,
    name: str,
    number: int,
    voltage_range: tuple[float, float],
    recommended_V: float,
    no_load_points: tuple[tuple[float, float], ...],
    effort: tuple[Effort, Registers],
    own: Registers,
    initial: Mapping[str, int],
    without: Iterable[str] = (),
    oldest_firmware: int = FIRST_WITH_WATCHDOG,
    baud_rates: Mapping[int, int] = BAUD_RATES,
) -> ServoModel:
    """A model by what it does not share: its `own` registers, in place of COMMON's or beside them, and `initial`."""
    fed = {"model_number": number, "present_input_voltage": round(recommended_V * 10)}
    table = {key: item for key, item in (COMMON | effort[1] | own).items() if key not in set(without)}
    return ServoModel(
        name=name,
        number=number,
        oldest_firmware=oldest_firmware,
        registers=_with_initial(table, fed | dict(initial)),
        effort=effort[0],
        voltage_range=voltage_range,
        recommended_V=recommended_V,
        no_load_points=no_load_points,
        baud_rates=baud_rates,
        hardware_errors=HARDWARE_ERRORS,
        ticks_per_turn=4096,
        rpm_per_velocity_unit=0.229,
        rpm2_per_acceleration_unit=214.577,
        volt_per_unit=0.1,
        watchdog_unit_s=0.020,
        position_mode=3,
        gain_divisor=128,
    )


def _with_initial(table: Registers, initial: Mapping[str, int]) -> Registers:
    changed = {key: replace(table[key], initial=value) for key, value in initial.items()}
    return dict(sorted((table | changed).items(), key=lambda item: item[1].address))
