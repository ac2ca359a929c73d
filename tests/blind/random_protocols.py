"""Protocols drawn at random: other robots, other gaits, other instruments, recorded well or badly.

3-20 joints on unequal links, eps 0.03-0.6; 2-8 gaits of three families, each at a duration and heading of its own,
played once to four times; 25-250 frames a second, marker noise 0.1-2 mm, a servo log at 10-200 Hz or none, holes,
perhaps a marker that no camera ever sees; rows that are held or run through.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from blind.cameras import Instruments
from blind.catalogue import ON_WHEELS
from blind.gaits import progress
from blind.protocol import Protocol, Setting
from blind.schedule import Plan
from blind.snake import EDGES, MASSES, Floats, Robot
from oracle.chain import serpenoid_joint_table

JOINTS, LENGTH_M, EPS = (3, 20), (0.3, 1.5), (0.03, 0.6)
GAITS, PLAYS, MOST_TRIALS = (2, 8), (1, 4), 16
FRAMES, NOISE_M, LOG_HERTZ, HOLES = (25, 250), (1e-4, 2e-3), (10, 200), (0.01, 0.3)
CYCLE_S, ROWS = (1.5, 6.0), (24, 100)
LEAST_PROGRESS, TRIES = 0.03, 60  # body lengths a cycle; afterwards the best that came up
# What nothing but the difference between a log and the cameras shows.
NEEDS_A_LOG = (
    "zero_offset", "loose_joint", "clock_offset", "marker_offset", "marker_offset_ahead", "marker_sway",
    "length_scale", "camera_stretch",
)  # fmt: skip


def _log(rng: np.random.Generator, ends: tuple[float, float]) -> float:
    return float(np.exp(rng.uniform(*np.log(ends))))


def draw_protocol(seed: int) -> Protocol:
    """One protocol; everything follows from the seed."""
    rng = np.random.default_rng([seed, 6])
    robot = _robot(rng)
    eps, slip_scale = _log(rng, EPS), float(np.exp(rng.uniform(-1.4, 0.4)))
    tools = _instruments(rng, robot)
    gaits, plays = int(rng.integers(GAITS[0], GAITS[1] + 1)), int(rng.integers(PLAYS[0], PLAYS[1] + 1))
    plays = min(plays, MOST_TRIALS // gaits)
    cycles, pause = int(rng.integers(1, 4)), float(np.round(rng.choice([0.0, rng.uniform(0.3, 1.5)], p=[0.2, 0.8]), 1))
    rows = int(rng.integers(*ROWS))
    settings = []
    for gait in range(gaits):
        cycle_s = float(np.round(_log(rng, CYCLE_S), 2))
        direction = -1 if gait == 0 and rng.uniform() < 0.7 else 1
        table = _table(rng, robot, eps, rows, cycle_s, direction)
        heading = float(rng.uniform(-np.pi, np.pi))
        back = 0.24 * robot.length * direction
        place = (-back * np.cos(heading), -back * np.sin(heading))
        plan = Plan(table, cycle_s, pause, cycles)
        settings.append(Setting(f"gait{gait + 1:02d}-a", gait, heading, plan, place))
    held = bool(rng.uniform() < 0.5)
    return Protocol(f"robot of {robot.joints} joints", robot, eps, slip_scale, tuple(settings), plays, tools, held)


def laid_anew(protocol: Protocol, seed: int) -> Protocol:
    """The same, every setting played at least twice, each time at a place and heading of its own."""
    rng, plays = np.random.default_rng([seed, 8]), max(protocol.plays, min(2, MOST_TRIALS // len(protocol.settings)))
    anew = [
        replace(
            s, label=f"{s.label}{chr(ord('a') + n)}", heading=float(rng.uniform(-np.pi, np.pi)),
            place=tuple(rng.uniform(-0.5, 0.5, 2) * protocol.robot.length),
        )
        for s in protocol.settings
        for n in range(plays)
    ]  # fmt: skip
    return replace(protocol, settings=tuple(anew), plays=1)


def once(protocol: Protocol) -> Protocol:
    """The same, every setting played once, for one cycle."""
    settings = tuple(replace(s, plan=replace(s.plan, cycles=1)) for s in protocol.settings)
    return replace(protocol, plays=1, settings=settings)


def effects_that_show(protocol: Protocol) -> list[str]:
    """Names that can be hidden in recordings of this kind."""
    return sorted(n for n in ON_WHEELS if protocol.instruments.log_hertz or n not in NEEDS_A_LOG)


def _robot(rng: np.random.Generator) -> Robot:
    joints = round(_log(rng, (JOINTS[0] - 0.49, JOINTS[1] + 0.49)))
    edges = np.exp(rng.normal(0, 0.25, joints + 1))
    masses = np.exp(rng.normal(0, 0.3, joints + 2))
    edges = np.round(edges / edges.sum() * _log(rng, LENGTH_M), 4)
    return Robot(edges, np.round(masses, 4), float(MASSES.sum() * (edges.sum() / EDGES.sum()) ** 3))


def _instruments(rng: np.random.Generator, robot: Robot) -> Instruments:
    hertz = 0.0 if rng.uniform() < 0.2 else _log(rng, LOG_HERTZ)
    unseen = (int(rng.integers(robot.vertices)),) if hertz and rng.uniform() < 0.25 else ()
    frames = float(np.round(_log(rng, FRAMES)))
    return Instruments(frames, _log(rng, NOISE_M), hertz, _log(rng, HOLES), unseen)


def _table(rng: np.random.Generator, robot: Robot, eps: float, rows: int, cycle_s: float, direction: int) -> Floats:
    best, farthest = None, -np.inf
    for _ in range(TRIES):
        table = FAMILIES[int(rng.integers(len(FAMILIES)))](rng, robot, rows, direction)
        table *= rng.uniform(0.5, 1.0) * robot.joint_limit / np.abs(table).max()
        speed = np.abs(np.diff(table, axis=0, append=table[:1])).max() * rows / cycle_s
        table = np.round(table * min(1.0, 0.8 * robot.speed_limit / speed), 6)
        far = direction * progress(table, eps, robot)
        if far > farthest:
            best, farthest = table, far
        if farthest > LEAST_PROGRESS:
            break
    if best is None:
        raise ArithmeticError("no gait moves")
    return best


def _ellipse(rng: np.random.Generator, robot: Robot, rows: int, direction: int) -> Floats:
    """The paper's family."""
    return serpenoid_joint_table(
        robot.edges / robot.length, rows, sigma=direction * rng.uniform(0.35, 1.0), a=rng.uniform(3.5, 7.5),
        xi=rng.uniform(0.6, 1.5), x_c=rng.uniform(-1.5, 1.5), y_c=rng.uniform(-1.5, 1.5),
        theta=rng.uniform(-np.pi, np.pi),
    )  # fmt: skip


def _two_waves(rng: np.random.Generator, robot: Robot, rows: int, direction: int) -> Floats:
    """A travelling wave of joint angles and its second harmonic, with a mean bend."""
    t, s = np.arange(rows)[:, None] / rows, np.linspace(0, 1, robot.joints)
    waves, phase = direction * rng.uniform(0.6, 1.6), rng.uniform(0, 2 * np.pi, 2)
    first = np.sin(2 * np.pi * (t + waves * s) + phase[0])
    second = rng.uniform(0.1, 0.4) * np.sin(2 * np.pi * (2 * t + rng.uniform(-2, 2) * s) + phase[1])
    return (first + second) * (1 + rng.uniform(-0.4, 0.4) * s) + rng.uniform(-0.2, 0.2)


def _each_its_own(rng: np.random.Generator, robot: Robot, rows: int, direction: int) -> Floats:
    """Every joint swings as wide as it likes, roughly in a wave."""
    t, s = np.arange(rows)[:, None] / rows, np.linspace(0, 1, robot.joints)
    phase = direction * rng.uniform(0.6, 1.6) * s + rng.normal(0, 0.06, robot.joints)
    return rng.uniform(0.4, 1.0, robot.joints) * np.sin(2 * np.pi * (t + phase)) + rng.normal(0, 0.1, robot.joints)


FAMILIES = (_ellipse, _two_waves, _each_its_own)
