"""What a trial promises, and who witnesses it."""

from __future__ import annotations

from dataclasses import dataclass

from serpenoid.measure.cells import Floats
from serpenoid.measure.clock import held
from serpenoid.measure.consistency.match import EXACT, PHYSICAL, Course, Prior
from serpenoid.measure.consistency.signals import Signal
from serpenoid.measure.schedule import Schedule


@dataclass(frozen=True)
class Claim:
    """A trial's promise and its witnesses, each on its own clock; any witness may be missing."""

    trial: str
    label: str  # of its joint table
    schedule: Schedule | None
    cameras: Signal | None = None
    servos: Signal | None = None
    commands: Signal | None = None

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
