"""A protocol: which joint tables are played how often on which robot, how it is filmed, and from which seed.

Everything random in a campaign follows from `seed` and the trial's name, so a trial played again is the same trial.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from serpenoid.arena.assembly import Assembly
from serpenoid.arena.changes import Changes
from serpenoid.arena.robot import NotNegative, Positive, Robot, robot_of
from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.files.schema import Line, Name, Record, Text, read_toml, validate
from serpenoid.problem import load as load_problem
from serpenoid.table_file import read_table

LONGEST_TRIAL_S = 3600
Share = Annotated[float, Field(ge=0, lt=1)]


class PlayedGait(Record):
    """One joint table, played at one or several cycle durations."""

    name: Name = Field(description="label of the gait; trials with the same label and duration are repeats")
    joint_table: str = Field(description="CSV with header joint_1,...,joint_m, radians; relative to the protocol")
    cycle_durations_s: tuple[Positive, ...] | None = Field(
        default=None, min_length=1, max_length=26, description="default: the protocol's"
    )
    headings_deg: tuple[float, ...] | None = Field(
        default=None, min_length=1, description="default: the protocol's; one heading: repeats cross the same floor"
    )


class Start(Record):
    """How the robot is set down; trial n takes heading n, and starts again when they are used up."""

    headings_deg: tuple[float, ...] = Field(default=(0.0,), min_length=1, description="tail to head, on the floor")
    heading_sd_deg: NotNegative = Field(default=3.0, description="nobody sets it down twice the same way")
    position_sd_m: NotNegative = Field(default=0.02, description="likewise, each way")


class Floor(Record):
    """How unequal the mats are."""

    variation: NotNegative = Field(default=0.06, description="SD of ln grip from place to place")
    trial_variation: NotNegative = Field(default=0.03, description="SD of ln grip from trial to trial (dust, warmth)")
    seed: int | None = Field(default=None, ge=0, description="which mats lie there; default: the protocol's seed")


class Cameras(Record):
    """The motion capture system."""

    frames_per_second: Positive = Field(default=120.0, le=240, description="the paper's cameras: 120")
    noise_m: NotNegative = Field(default=0.0002, description="SD of a marker's position, each axis")
    dropout: Share = Field(default=0.02, description="share of frames in which a marker is occluded")
    dropout_burst_s: Positive = Field(default=0.15, description="mean length of one occlusion")
    unlabelled: Annotated[float, Field(ge=0, le=1)] = Field(
        default=0.0, description="share of bursts exported as fragments"
    )


class Logs(Record):
    """The servo log and the power sensor."""

    servo_hz: Positive = Field(default=40.0, le=240, description="readings of all servos per second")
    power_hz: Positive = Field(default=50.0, le=240, description="INA260 with averaging: 20 to 100")
    power_noise_W: NotNegative = Field(default=0.02, description="SD of one reading")
    clocks_differ_s: NotNegative = Field(
        default=2.0, le=1e6, description="servo and power clocks start up to this long before cameras"
    )


class PlayedRobot(Robot):
    """The robot's numbers, and what is hidden in it."""

    changes: Changes = Changes()

    @model_validator(mode="after")
    def _changes_fit(self) -> Self:
        self.assembled()
        return self

    def assembled(self) -> Assembly:
        return self.changes.apply(Assembly.healthy(self))


class Protocol(Record):
    """A protocol file."""

    file_kind: ClassVar[str | None] = "protocol"

    format: Literal[1] = 1
    name: Line = "arena"
    description: Text = ""
    seed: int = Field(default=0, ge=0)
    problem: str | None = Field(
        default=None, description="problem file whose body is played, relative to the protocol; default: the paper's"
    )
    trials: int = Field(default=3, ge=1, le=1000, description="repeats of each gait and duration")
    cycles: int = Field(default=3, ge=1, le=10_000)
    cycle_duration_s: Positive = Field(default=5.0, description="for gaits that do not say")
    pause_s: NotNegative = Field(default=2.0, description="after every cycle")
    gait: tuple[PlayedGait, ...] = Field(min_length=1)
    start: Start = Start()
    floor: Floor = Floor()
    cameras: Cameras = Cameras()
    logs: Logs = Logs()
    robot: PlayedRobot = PlayedRobot()

    @model_validator(mode="after")
    def _names_differ(self) -> Self:
        names = [gait.name for gait in self.gait]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"gait names must differ, `{twice[0]}` is there twice")
        slowest = max(max(gait.cycle_durations_s or (self.cycle_duration_s,)) for gait in self.gait)
        if self.cycles * (slowest + self.pause_s) > LONGEST_TRIAL_S:
            raise ValueError(f"`cycles` times cycle and pause must be at most {LONGEST_TRIAL_S} s, a trial's longest")
        return self


def load_protocol(path: str | Path) -> tuple[Protocol, dict[str, Floats]]:
    """The protocol and its joint tables by gait name, each checked against what the servos can be told."""
    path, data = Path(path), read_toml(path, "protocol")
    if isinstance(data.get("problem"), str) and isinstance(data.get("robot", {}), dict):
        data["robot"] = robot_of(load_problem(path.parent / data["problem"]).body, data.get("robot"))
    protocol = validate(Protocol, data, str(path))
    tables = {}
    for gait in protocol.gait:
        try:
            tables[gait.name] = read_joint_table(path.parent / gait.joint_table, protocol.robot.servos)
        except InputError as error:
            raise InputError(f"{path}: gait `{gait.name}`: {error}") from None
    return protocol, tables


def read_joint_table(path: Path, servos: int) -> Floats:
    """Joint angles, shape (T, m) [rad], within what the servos' brackets allow."""
    table = read_table(path, servos)
    row, column = np.unravel_index(np.abs(table).argmax(), table.shape)
    if abs(table[row, column]) > math.pi / 2:
        raise InputError(
            f"{path}:{row + 2}: joint_{column + 1} must be within 90 degrees, got {table[row, column]:.4g} rad. "
            "Links collide there, which the arena does not know."
        )
    return table
