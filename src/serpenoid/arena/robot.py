"""The arena's robot in numbers: the paper's ten-servo snake, or another chain, each value with its source. SI units.

Sources: [P] the paper's experimental protocol; [D] the servo maker's data sheet (XL430-W250); [A] assumed, because no
source gives it - these are the numbers to change first when the arena should resemble another laboratory.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from serpenoid.arena.chain import Chain, chain_of
from serpenoid.body import Body, Floats
from serpenoid.files.schema import Record

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0), AfterValidator(abs)]  # NumPy takes -0.0 for a negative spread

PAPER_SERVOS = 10
PAPER_SPACING_M = 0.92 / (PAPER_SERVOS + 1)
TICKS = 4096  # per turn [D]
TICK = 2 * math.pi / TICKS
GRAVITY = 9.81  # m/s^2
WHEEL_SHARE = 0.3  # of a light vertex: its wheels are not all of it


class Robot(Record):
    """Every number of the healthy robot; a protocol's `[robot]` section may override any of them."""

    chain: Chain | None = Field(default=None, description="another body than the paper's; `problem` fills it in")
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
        if self.chain is None and self.board_mass_kg < 0:
            raise ValueError(f"the parts weigh {-self.board_mass_kg:.3f} kg more than `mass_kg`, got {self.mass_kg}")
        return self

    @property
    def links(self) -> Chain:
        """The chain: a given one, or the paper's, whose end markers stand mid-link."""
        if self.chain is not None:
            return self.chain
        half = self.spacing_m / 2
        edges = (half, *[self.spacing_m] * (PAPER_SERVOS - 1), half)
        joint = self.servo_mass_kg + self.wheel_pair_mass_kg + self.connector_mass_kg
        end = self.battery_mass_kg + self.wheel_pair_mass_kg + self.connector_mass_kg
        masses = (end, *[joint] * PAPER_SERVOS, end + max(self.board_mass_kg, 1e-9))
        return Chain(edges_m=edges, joints=tuple(range(1, PAPER_SERVOS + 1)), masses_kg=masses)

    @property
    def servos(self) -> int:
        """m, numbered from the tail."""
        return PAPER_SERVOS if self.chain is None else len(self.chain.joints)

    @property
    def wheels(self) -> int:
        """Wheel pairs, numbered like the vertices: 0 under the tail marker, then behind the joints, last the head."""
        return PAPER_SERVOS + 2 if self.chain is None else len(self.chain.edges_m) + 1

    @property
    def spacing_m(self) -> float:
        """Between neighbouring joints of the paper's robot."""
        return self.length_m / (PAPER_SERVOS + 1)

    @property
    def size(self) -> float:
        """The mean distance between neighbouring vertices over the paper's 84 mm between joints."""
        return 1.0 if self.chain is None else float(np.mean(self.chain.edges_m)) / PAPER_SPACING_M

    @property
    def board_mass_kg(self) -> float:
        """What is left of the paper's mass: board, power sensor, switch and cables, in the head."""
        servos = PAPER_SERVOS * self.servo_mass_kg
        wheels = (PAPER_SERVOS + 2) * self.wheel_pair_mass_kg
        connectors = (PAPER_SERVOS + 2) * self.connector_mass_kg
        return self.mass_kg - servos - wheels - connectors - 2 * self.battery_mass_kg

    @property
    def edge_lengths_m(self) -> Floats:
        """The chain's edges from tail marker to head marker, shape (N - 1,)."""
        return np.array(self.links.edges_m)

    @property
    def vertex_masses_kg(self) -> Floats:
        """Mass carried at each vertex, shape (N,): what a kitchen scale finds part by part."""
        return np.array(self.links.masses_kg)

    @property
    def loads(self) -> Floats:
        """Of each joint, shape (m,): the moment that turns the lighter side of the straight body about it over the
        floor, sideways on all wheels, over the stall torque. A wave asks for less, as its sides oppose each other."""
        chain = self.links
        arms = chain.places_m - chain.places_m[list(chain.joints)][:, None]
        moments = self.grip * GRAVITY * np.array(chain.masses_kg) * np.abs(arms)
        sides = [np.where(side, moments, 0.0).sum(axis=1) for side in (arms < 0, arms > 0)]
        return np.minimum(*sides) / self.stall_torque

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


def robot_of(body: Body, given: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """`[robot]` for the body of a problem file: what is `given` there stays, the rest is scaled to the body.

    Lengths of wheels and axles are those of the paper's robot times the mean edge over its spacing; the joints'
    vertical stiffness grows with weight times length, so that all robots sag alike. Servos are XL430.
    """
    given = dict(given or {})
    chain = chain_of(body)
    if _is_the_papers(chain):
        return given
    paper, mass = Robot(), sum(chain.masses_kg)
    size = float(np.mean(chain.edges_m)) / PAPER_SPACING_M
    length = sum(chain.edges_m)
    own = {
        "length_m": length,
        "mass_kg": mass,
        "wheel_diameter_m": size * paper.wheel_diameter_m,
        "wheel_offset_m": size * paper.wheel_offset_m,
        "track_m": size * paper.track_m,
        "wheel_pair_mass_kg": min(paper.wheel_pair_mass_kg, WHEEL_SHARE * min(chain.masses_kg)),
        "bend_stiffness": paper.bend_stiffness * mass * length / (paper.mass_kg * paper.length_m),
    }
    return own | given | {"chain": chain}


def _is_the_papers(chain: Chain) -> bool:
    """A body with the paper's edges and mass is the paper's robot, whose parts are known one by one."""
    paper = Robot()
    if chain.joints != paper.links.joints or len(chain.edges_m) != len(paper.links.edges_m):
        return False
    same_mass = abs(sum(chain.masses_kg) - paper.mass_kg) < 1e-3
    return same_mass and bool(np.allclose(chain.edges_m, paper.edge_lengths_m, rtol=0, atol=1e-5))


def too_weak(robot: Robot) -> str:
    """That servos cannot turn the body over the floor, in words; empty if they can."""
    loads = robot.loads
    worst = int(loads.argmax())
    if loads[worst] <= 1:
        return ""
    needs, stalls = loads[worst] * robot.stall_torque, robot.stall_torque
    return (
        f"joint {worst + 1} needs {needs:.2g} N m to turn the lighter side of the body over the floor, and its servo "
        f"stalls at {stalls:.2g} N m: joints will not follow their commands. Take a lighter or shorter body, or "
        "another `stall_torque` in [robot]"
    )
