"""A servo model as one value: registers, units and published limits. Everything else asks it, and names none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil, degrees, tau

WATCHDOG_TRIPPED = -1  # what Bus Watchdog (98) then reads
TORQUE_SHARE = 0.75  # of its full output: what no healthy joint needs


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


@dataclass(frozen=True)
class Block:
    """Neighbouring registers that are read in one exchange."""

    address: int
    size: int


@dataclass(frozen=True)
class Shared:
    """One packet sends all goals, one switches all torques off, one asks for all states; the sketch knows one volt."""

    goal: Register
    torque: Register
    state: Block
    volt_per_unit: float


@dataclass(frozen=True)
class Effort:
    """What a servo says its motor gives: a log's column, in steps of `per_unit`; `full` is what it reads at stall.

    `load`: share of the full output, which the servo infers from what it applies [-1..1]; `current`: of the motor,
    measured [A]; `supply_current`: of the whole servo, measured at its input [A].
    """

    register: str
    column: str
    per_unit: float
    full: float


@dataclass(frozen=True, eq=False)
class ServoModel:
    """`number`: what it answers to a ping; `voltage_range` [V]: what it may be fed with.

    no_load_points: (V, rpm) as published; baud_rates: register value of Baud Rate (8) -> bits per second;
    hardware_errors: bit of Hardware Error Status (70) -> what it is and what to do;
    gain_divisor: Position P Gain (84) over it is PWM units per tick of position error.
    """

    name: str
    number: int
    oldest_firmware: int
    registers: Mapping[str, Register]
    effort: Effort
    voltage_range: tuple[float, float]
    recommended_V: float
    no_load_points: tuple[tuple[float, float], ...]
    baud_rates: Mapping[int, int]
    hardware_errors: Mapping[int, tuple[str, str]]
    ticks_per_turn: int
    rpm_per_velocity_unit: float
    rpm2_per_acceleration_unit: float  # rev/min^2
    volt_per_unit: float
    watchdog_unit_s: float
    position_mode: int
    gain_divisor: int

    @property
    def radians_per_tick(self) -> float:
        return tau / self.ticks_per_turn

    @property
    def last_tick(self) -> int:
        """The largest position [ticks] that it can be limited to."""
        return self.registers["maximum_position_limit"].initial

    @property
    def fastest(self) -> tuple[float, float]:
        """(V, rpm) of the highest published no-load speed."""
        return max(self.no_load_points)

    def no_load_speed_rpm(self, voltage: float) -> float:
        """No-load speed [rpm] at `voltage` [V]: proportional to it, on the safe side of every published point.

        The line goes through the point that is slowest per volt.
        """
        volts, rpm = min(self.no_load_points, key=lambda point: point[1] / point[0])
        return rpm * voltage / volts

    def velocity_units(self, rpm: float) -> int:
        """Velocity Limit (44) and Profile Velocity (112), never above `rpm`."""
        return max(1, int(rpm / self.rpm_per_velocity_unit + 1e-9))

    @property
    def tracking_limit_deg(self) -> float:
        """Three quarters of the position error at which the factory's P gain asks for full output, in whole degrees.

        Of the XL430-W250-T twice the largest error of a healthy robot on a floor that grips (6.3 degrees:
        `results/benchmarks/robustness.md`); errors under the same share of the torque are as the gains.
        """
        gain = self.registers["position_p_gain"].initial / self.gain_divisor
        return float(ceil(TORQUE_SHARE * degrees(self.registers["pwm_limit"].initial / gain * self.radians_per_tick)))

    @property
    def state(self) -> Block:
        """Effort, speed, position, voltage and temperature."""
        return self._block(self.effort.register, "present_temperature")

    @property
    def health(self) -> Block:
        """Torque, hardware errors and watchdog."""
        return self._block("torque_enable", "bus_watchdog")

    @property
    def shared(self) -> Shared:
        """What all servos of a chain must have alike."""
        return Shared(self.registers["goal_position"], self.registers["torque_enable"], self.state, self.volt_per_unit)

    def _block(self, first: str, last: str) -> Block:
        start = self.registers[first].address
        return Block(start, self.registers[last].end - start)

    def name_hardware_errors(self, bits: int) -> str:
        """`overheating (let it cool; ...) and overload (...)` for the bits of Hardware Error Status."""
        named = [f"{what} ({remedy})" for bit, (what, remedy) in self.hardware_errors.items() if bits >> bit & 1]
        return " and ".join(named) or f"unknown hardware error bits {bits:#04x}"
