"""What is planned before anything is hidden: robot, gaits, settings, instruments; usually the paper's snake."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from blind.cameras import Instruments
from blind.gaits import random_table
from blind.schedule import Plan
from blind.snake import SNAKE10, Floats, Robot

CYCLES = 2
REPEATS = 2
# gait, heading, duration: every gait once, the first gait at all durations and headings
Combination = tuple[int, int, int]
COMBINATIONS: tuple[Combination, ...] = (
    (0, 0, 0),
    (1, 1, 1),
    (2, 2, 2),
    (3, 0, 1),
    (4, 1, 2),
    (5, 2, 0),
    (0, 1, 2),
    (0, 2, 1),
)


@dataclass(frozen=True)
class Setting:
    """One combination that is repeated: label such as `gait01-a`, gait number, start heading, table and durations.

    place: centroid at the start [m]; by default 0.2 m behind the middle of the floor, so that the middle is crossed.
    """

    label: str
    gait: int
    heading: float
    plan: Plan
    place: tuple[float, float] | None = None

    @property
    def start(self) -> Floats:
        """Where the body is put, but for the hand that puts it (3,)."""
        back = 0.2 * (1 if self.gait else -1)
        x, y = self.place or (-back * np.cos(self.heading), -back * np.sin(self.heading))
        return np.array([x, y, self.heading])


@dataclass(frozen=True)
class Protocol:
    """plays: trials of each setting. held: rows are held and jump where the servos do not follow at once (else they are
    run through on straight lines); slip_scale: of the random slips."""

    name: str
    robot: Robot
    eps: float
    slip_scale: float
    settings: tuple[Setting, ...]
    plays: int = REPEATS
    instruments: Instruments = Instruments()
    held: bool = False


def usual(seed: int, combinations: Sequence[Combination] = COMBINATIONS) -> Protocol:
    """The ten-servo snake: six gaits, three headings, three durations, everything twice."""
    rng = np.random.default_rng([seed, 0])
    eps, slip_scale = float(np.exp(rng.uniform(np.log(0.12), np.log(0.3)))), float(np.exp(rng.uniform(-1.4, 0.4)))
    return Protocol("snake10", SNAKE10, eps, slip_scale, tuple(_settings(rng, combinations)))


def with_joints(protocol: Protocol, joints: int) -> Protocol:
    """The same of a snake that has only the first joints, between the same tail and head; how long a search of the
    catalogue takes grows with the square of them and more."""
    robot, rest = protocol.robot, protocol.robot.joints - joints
    edges, masses = (np.delete(x, np.s_[joints : joints + rest]) for x in (robot.edges, robot.masses))
    shorter = replace(robot, edges=edges, masses=masses, mass_kg=robot.mass_kg * masses.sum() / robot.masses.sum())
    played = (replace(s, plan=replace(s.plan, table=s.plan.table[:, :joints])) for s in protocol.settings)
    return replace(protocol, name=f"snake{joints}", robot=shorter, settings=tuple(played))


def _settings(rng: np.random.Generator, combinations: Sequence[Combination]) -> list[Setting]:
    durations = rng.uniform(2.2, 3.2) * np.array([1.0, 1.7, 2.8])
    headings = rng.uniform(-np.pi, np.pi) + np.array([0.0, 2.0, 4.0]) * np.pi / 3
    pause = float(np.round(rng.uniform(0.8, 1.5), 1))
    tables = [random_table(rng, -1 if i == 0 else 1, durations[0]) for i in range(6)]
    settings = []
    for gait, heading, duration in combinations:
        letter = "abc"[sum(s.gait == gait for s in settings)]
        plan = Plan(tables[gait], float(np.round(durations[duration], 2)), pause, CYCLES)
        settings.append(Setting(f"gait{gait + 1:02d}-{letter}", gait, float(headings[heading]), plan))
    return settings
