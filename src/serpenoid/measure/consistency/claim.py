"""What a trial promises, and who witnesses it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from serpenoid.body import Body
from serpenoid.measure.cells import Floats
from serpenoid.measure.clock import held
from serpenoid.measure.consistency.match import EXACT, PHYSICAL, Course, Prior
from serpenoid.measure.consistency.signals import Signal
from serpenoid.measure.formats.columns import AngleUnit
from serpenoid.measure.schedule import Schedule
from serpenoid.measure.servo_alignment import seen_corners
from serpenoid.measure.shapes.links import bends, chain_vertices


@dataclass(frozen=True)
class Outline:
    """What a film shows whose markers are not at the joints: the bends (F, K - 2) of the polygon through K vertices."""

    body: Body
    corners: tuple[int, ...]
    shown: Signal

    def of(self, angles: Floats) -> Floats:
        """The same bends of joint angles (R, m)."""
        points = chain_vertices(self.body, np.zeros((len(angles), 3)), angles)
        return bends(points[:, list(self.corners)])


def outline(body: Body, time_s: Floats, vertices: Floats) -> Outline | None:
    """Of vertices (F, N, 2) of a robot, NaN hidden; None: those that are seen are no polygon."""
    corners = tuple(seen_corners(body, vertices))
    if body.is_animal or len(corners) < 3:
        return None
    return Outline(body, corners, Signal(time_s, bends(vertices[:, list(corners)])))


@dataclass(frozen=True)
class Claim:
    """A trial's promise and its witnesses, each on its own clock; any witness may be missing.

    outline: where cameras do not show the joints' angles; angle_unit: in which the servo log was read.
    """

    trial: str
    label: str  # of its joint table
    schedule: Schedule | None
    cameras: Signal | None = None
    servos: Signal | None = None
    commands: Signal | None = None
    outline: Outline | None = None
    angle_unit: AngleUnit = "rad"

    @property
    def film(self) -> Signal | None:
        """How the body bends on film: its joints' angles, else its outline's."""
        if self.outline is not None and not (self.cameras is not None and self.cameras.enough):
            return self.outline.shown
        return self.cameras

    @property
    def witnesses(self) -> list[tuple[Signal | None, str, Prior]]:
        """The schedule is laid over the first that is there; each with its name, and how closely it keeps a promise."""
        return [
            (self.commands, "the servo log's commands", EXACT),
            (self.servos, "the servo log's positions", PHYSICAL),
            (self.cameras, "the recorded shapes", PHYSICAL),
        ]


def same_joints(cameras: Signal, servos: Signal) -> bool:
    """Whether the two can be laid over each other."""
    return cameras.enough and servos.enough and cameras.values.shape[1] == servos.values.shape[1]


def logged(servos: Signal, period: float | None) -> Course:
    """What a servo log says, held beyond its ends."""
    time, values = servos.time_s[servos.known] - servos.time_s[servos.known][0], servos.values[servos.known]
    total = float(time[-1])

    def angles(at: Floats) -> Floats:
        return held(time, values, at)

    return Course(angles, total, period or total, told=False)
