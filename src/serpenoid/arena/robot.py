"""The arena's robot in numbers: the paper's ten-servo snake, each value with its source. SI units.

Sources: [P] the paper's experimental protocol; [D] the servo maker's data sheet (XL430-W250); [A] assumed, because no
source gives it - these are the numbers to change first when the arena should resemble another laboratory.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from serpenoid.body import Floats
from serpenoid.schema import Record

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]

SERVOS = 10
WHEELS = 12  # wheel pairs, numbered like the vertices: 0 under the tail marker, 1..10 behind the joints, 11 the head
TICKS = 4096  # per turn [D]
TICK = 2 * math.pi / TICKS


class Robot(Record):
    """Every number of the healthy robot; a protocol's `[robot]` section may override any of them."""

    length_m: Positive = Field(default=0.92, description="nose to tail end [P]")
    mass_kg: Positive = Field(default=1.38, description="all of it [P]")
    servo_mass_kg: Positive = Field(default=0.057, description="one servo [D]")
    wheel_pair_mass_kg: Positive = Field(default=0.020, description="two wheels and their axle [A]")
    connector_mass_kg: Positive = Field(default=0.0217, description="one printed connector with screws and marker [A]")
    battery_mass_kg: Positive = Field(
        default=0.140, description="one 1500 mAh three-cell battery, in head and tail [A]"
    )
    wheel_diameter_m: Positive = Field(default=0.056, description="[P]")
    wheel_offset_m: NotNegative = Field(default=0.01823, description="axle behind its joint, towards the tail [P]")
    track_m: Positive = Field(default=0.050, description="between the two wheels of a pair [A]")
    axle: Literal["common", "independent"] = Field(
        default="common", description="'connected by an axle' [P]: turn together"
    )

    grip: Positive = Field(default=0.6, description="rubber on foam: Coulomb friction coefficient [A]")
    rolling_resistance: NotNegative = Field(default=0.05, description="rolling force over load: bearing, foam [A]")
    rolling_damping: NotNegative = Field(default=1.0, description="the same, growing with speed, per m/s [A]")
    contact_time_s: Positive = Field(
        default=0.05, description="of the foam under the load: it gives half a millimetre [A]"
    )
    bend_stiffness: Positive = Field(default=20.0, description="vertical stiffness of one joint, N m/rad [A]")

    voltage_V: Annotated[float, Field(ge=6.5, le=14.0)] = Field(default=11.1, description="battery under no load [P]")
    battery_resistance: NotNegative = Field(default=0.05, description="battery and wiring [A], ohm")
    stall_torque: Positive = Field(default=1.4, description="at 11.1 V, N m [D]")
    stall_current_A: Positive = Field(default=1.3, description="at 11.1 V [D]")
    no_load_rpm: Positive = Field(default=57.0, description="at 11.1 V [D]")
    standby_current_A: NotNegative = Field(default=0.052, description="one servo, powered and still [D]")
    controller_power_W: NotNegative = Field(default=0.6, description="board and sensor [A]")
    position_p_gain: Positive = Field(default=640.0, description="register 84, as delivered [D]")
    gear_friction: NotNegative = Field(
        default=0.03, description="dry friction of the gear train at its output, N m [A]"
    )
    rotor_inertia: Positive = Field(default=0.008, description="seen at the output shaft, kg m^2 [A]")
    profile_s: NotNegative | None = Field(default=0.0, description="time over which a goal is approached; 0: jumps")

    timestep_s: Positive = Field(default=1 / 360, description="of the contact simulation")

    @model_validator(mode="after")
    def _mass_left_for_the_board(self) -> Self:
        if self.board_mass_kg < 0:
            raise ValueError(f"the parts weigh {-self.board_mass_kg:.3f} kg more than `mass_kg`, got {self.mass_kg}")
        return self

    @property
    def spacing_m(self) -> float:
        """Between neighbouring joints."""
        return self.length_m / (SERVOS + 1)

    @property
    def board_mass_kg(self) -> float:
        """What is left of the mass: board, power sensor, switch and cables, in the head."""
        servos = SERVOS * self.servo_mass_kg
        wheels = WHEELS * self.wheel_pair_mass_kg
        connectors = WHEELS * self.connector_mass_kg
        return self.mass_kg - servos - wheels - connectors - 2 * self.battery_mass_kg

    @property
    def edge_lengths_m(self) -> Floats:
        """The chain's edges from tail marker to head marker, shape (11,): the end markers stand mid-link."""
        half = self.spacing_m / 2
        return np.array([half, *[self.spacing_m] * (SERVOS - 1), half])

    @property
    def vertex_masses_kg(self) -> Floats:
        """Mass carried at each vertex, shape (12,): what a kitchen scale finds part by part."""
        joint = self.servo_mass_kg + self.wheel_pair_mass_kg + self.connector_mass_kg
        end = self.battery_mass_kg + self.wheel_pair_mass_kg + self.connector_mass_kg
        return np.array([end, *[joint] * SERVOS, end + self.board_mass_kg])

    @property
    def torque_constant(self) -> float:
        """N m at the output per ampere."""
        return self.stall_torque / self.stall_current_A

    @property
    def resistance(self) -> float:
        """Winding and driver, ohm."""
        return 11.1 / self.stall_current_A

    @property
    def back_emf_constant(self) -> float:
        """Volts per rad/s of the output: full voltage is used up at the no-load speed."""
        return 11.1 / (self.no_load_rpm * math.pi / 30)

    @property
    def servo_stiffness(self) -> float:
        """N m per radian of position error at 11.1 V: 885 counts of P gain / 128 per tick are the full voltage [D]."""
        volts_per_tick = 11.1 * self.position_p_gain / 128 / 885
        return self.torque_constant / self.resistance * volts_per_tick / TICK

    @property
    def servo_damping(self) -> float:
        """N m per rad/s: the motor's back EMF; with the stiffness it makes the servo's lag."""
        return self.torque_constant * self.back_emf_constant / self.resistance
