"""What can be hidden in the robot or under it: each change turns one assembly into another (`[robot.changes.NAME]`).

Vertices 0 (tail) to N - 1 (head) name wheel pairs and markers, joints 1 to m servos, links 0 (tail) to m (head).
The last group (magnet, tether, gust) is outside what the package's catalogue of effects can name, on purpose.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from serpenoid.arena.assembly import Assembly, Patch, Pull
from serpenoid.arena.robot import NotNegative, Positive
from serpenoid.files.schema import Record

Vertex = Annotated[int, Field(ge=0)]
Joint = Annotated[int, Field(ge=1)]
Link = Annotated[int, Field(ge=0)]
Factor = Annotated[float, Field(ge=0, le=10)]


class SeizedWheel(Record):
    """A wheel pair that does not turn, or turns hard."""

    vertex: Vertex
    torque: Positive = Field(default=1.0, description="N m; a tyre slides at about 0.02, so 1 is seized, 0.01 is worn")

    def apply(self, assembly: Assembly) -> Assembly:
        return assembly.with_item("bearing", self.vertex, assembly.bearing[self.vertex] + self.torque)


class LiftedWheel(Record):
    """A wheel pair that hangs above the floor: lost contact; its neighbours carry its load."""

    vertex: Vertex
    height_m: Positive = 0.005

    def apply(self, assembly: Assembly) -> Assembly:
        return assembly.with_item("lift", self.vertex, assembly.lift[self.vertex] + self.height_m)


class SmoothTyre(Record):
    """One wheel pair has lost its rubber."""

    vertex: Vertex
    factor: Factor = 0.3

    def apply(self, assembly: Assembly) -> Assembly:
        return assembly.with_item("grip", self.vertex, assembly.grip[self.vertex] * self.factor)


class Toe(Record):
    """A wheel set mounted at an angle, counter-clockwise."""

    vertex: Vertex
    angle_deg: Annotated[float, Field(ge=-45, le=45)] = 8.0

    def apply(self, assembly: Assembly) -> Assembly:
        return assembly.with_item("toe", self.vertex, assembly.toe[self.vertex] + math.radians(self.angle_deg))


class Ratchet(Record):
    """All wheels roll backward with more resistance than forward."""

    torque: Positive = Field(default=0.003, description="N m per wheel pair")

    def apply(self, assembly: Assembly) -> Assembly:
        return replace(assembly, backward=assembly.backward + self.torque)


class Sideways(Record):
    """Tyres that grip less when pushed to one side than to the other (their tread leans)."""

    factor: Factor = 0.5
    weak_side: Literal["left", "right"] = "left"

    def apply(self, assembly: Assembly) -> Assembly:
        return assembly.with_item("grip_against", 0 if self.weak_side == "left" else 1, self.factor)


class Payload(Record):
    """A mass on one link that nobody weighed."""

    link: Link
    mass_kg: Positive = 0.3

    def apply(self, assembly: Assembly) -> Assembly:
        return assembly.with_item("payload", self.link, assembly.payload[self.link] + self.mass_kg)


class LooseJoint(Record):
    """Play between a servo and its link; the servo's reading does not show it."""

    joint: Joint
    play_deg: Positive = 6.0

    def apply(self, assembly: Assembly) -> Assembly:
        return assembly.with_item("backlash", self.joint - 1, math.radians(self.play_deg))


class WeakServo(Record):
    """A servo with little torque and a soft controller."""

    joint: Joint
    factor: Annotated[float, Field(gt=0, le=1)] = 0.1

    def apply(self, assembly: Assembly) -> Assembly:
        soft = assembly.with_item("gain", self.joint - 1, assembly.gain[self.joint - 1] * self.factor)
        return soft.with_item("torque", self.joint - 1, soft.torque[self.joint - 1] * self.factor)


class ShortStroke(Record):
    """A servo that goes only part of every commanded angle."""

    joint: Joint
    factor: Factor = 0.6

    def apply(self, assembly: Assembly) -> Assembly:
        return assembly.with_item("scale", self.joint - 1, self.factor)


class StuckJoint(Record):
    """A servo that stays where it is; its reading shows it."""

    joint: Joint
    angle_deg: Annotated[float, Field(ge=-60, le=60)] = 0.0

    def apply(self, assembly: Assembly) -> Assembly:
        return assembly.with_item("stuck", self.joint - 1, math.radians(self.angle_deg))


class WrongZero(Record):
    """A horn mounted askew: true angle minus reading."""

    joint: Joint
    angle_deg: Annotated[float, Field(ge=-45, le=45)] = 6.0

    def apply(self, assembly: Assembly) -> Assembly:
        return assembly.with_item("zero", self.joint - 1, math.radians(self.angle_deg))


class BatterySag(Record):
    """The battery starts low or empties during the trial: slower and weaker servos."""

    voltage_V: Annotated[float, Field(ge=6, le=14)] = 8.0
    drop_V_per_s: NotNegative = 0.0

    def apply(self, assembly: Assembly) -> Assembly:
        return replace(assembly, voltage_V=self.voltage_V, voltage_drop=self.drop_V_per_s)


class Slope(Record):
    """A floor out of level."""

    angle_deg: Annotated[float, Field(ge=0, le=30)] = 2.0
    downhill_deg: float = Field(default=0.0, description="direction of the pull on the floor")

    def apply(self, assembly: Assembly) -> Assembly:
        return replace(assembly, slope_rad=math.radians(self.angle_deg), downhill_rad=math.radians(self.downhill_deg))


class SlipperyPatch(Record):
    """A round place with another grip."""

    x_m: float = 0.0
    y_m: float = 0.0
    radius_m: Positive = 0.3
    factor: Factor = 0.3

    def apply(self, assembly: Assembly) -> Assembly:
        patch = Patch(self.x_m, self.y_m, self.radius_m, max(self.factor, 1e-3))
        return replace(assembly, patches=(*assembly.patches, patch))


class DisplacedMarker(Record):
    """A marker glued beside its place."""

    vertex: Vertex
    along_m: float = 0.01
    across_m: float = 0.0

    def apply(self, assembly: Assembly) -> Assembly:
        return assembly.with_item("marker", self.vertex, np.array([self.along_m, self.across_m]))


class Magnet(Record):
    """A point on the floor that draws one link."""

    link: Link | None = Field(default=None, description="default: the head's")
    x_m: float = 0.3
    y_m: float = 0.3
    force_N: float = 2.0
    reach_m: Positive = 0.15

    def apply(self, assembly: Assembly) -> Assembly:
        return _pulled(
            assembly, Pull("magnet", _link(assembly, self.link, 1.0), (self.x_m, self.y_m, self.force_N, self.reach_m))
        )


class Tether(Record):
    """A cable that pulls one link back once it is taut."""

    link: Link = 0
    x_m: float = -0.5
    y_m: float = 0.0
    stiffness: Positive = Field(default=5.0, description="N/m")
    length_m: Positive = 0.4

    def apply(self, assembly: Assembly) -> Assembly:
        return _pulled(
            assembly,
            Pull("tether", _link(assembly, self.link, 0.0), (self.x_m, self.y_m, self.stiffness, self.length_m)),
        )


class Gust(Record):
    """A push on one link for a short while."""

    link: Link | None = Field(default=None, description="default: the middle one")
    force_x_N: float = 0.0
    force_y_N: float = 3.0
    begin_s: NotNegative = 4.0
    duration_s: Positive = 1.0

    def apply(self, assembly: Assembly) -> Assembly:
        values = (self.force_x_N, self.force_y_N, self.begin_s, self.duration_s)
        return _pulled(assembly, Pull("gust", _link(assembly, self.link, 0.5), values))


def _link(assembly: Assembly, named: int | None, share: float) -> int:
    """The named link, or the one at a share of the way from tail to head."""
    last = assembly.robot.servos
    if named is not None and named > last:
        raise IndexError
    return round(share * last) if named is None else named


def _pulled(assembly: Assembly, pull: Pull) -> Assembly:
    return replace(assembly, pulls=(*assembly.pulls, pull))


class Changes(Record):
    """At most one change of each name; none by default."""

    seized_wheel: SeizedWheel | None = None
    lifted_wheel: LiftedWheel | None = None
    smooth_tyre: SmoothTyre | None = None
    toe: Toe | None = None
    ratchet: Ratchet | None = None
    sideways: Sideways | None = None
    payload: Payload | None = None
    loose_joint: LooseJoint | None = None
    weak_servo: WeakServo | None = None
    short_stroke: ShortStroke | None = None
    stuck_joint: StuckJoint | None = None
    wrong_zero: WrongZero | None = None
    battery_sag: BatterySag | None = None
    slope: Slope | None = None
    slippery_patch: SlipperyPatch | None = None
    displaced_marker: DisplacedMarker | None = None
    magnet: Magnet | None = None
    tether: Tether | None = None
    gust: Gust | None = None

    def apply(self, assembly: Assembly) -> Assembly:
        for name in type(self).model_fields:
            change = getattr(self, name)
            try:
                assembly = assembly if change is None else change.apply(assembly)
            except IndexError:
                parts = f"it has {assembly.robot.servos} joints and {assembly.robot.wheels} vertices"
                text = f"`{name}` names a vertex, joint or link that this robot does not have: {parts}"
                raise ValueError(text) from None
        return assembly
