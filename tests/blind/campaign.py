"""A campaign in memory: gaits, trials, and what cameras and servos saw of them; everything follows from one seed.

Separate random streams for gaits, effects, slips and cameras: with the same seed, a campaign with an effect differs
from the one without by the effect alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from blind import catalogue, outside
from blind.cameras import Clocks, Film, ServoLog, film, servo_log
from blind.catalogue import Effect, World
from blind.gaits import random_table
from blind.motion import Drive
from blind.schedule import Plan, grid, realise
from blind.snake import Floats

CYCLES = 2
SLIP_PER_CYCLE = np.array([1e-3, 0.8e-3, 2.5e-3])  # m forwards, m sideways, rad: standard deviations
SLIP_BLOCK_S = 0.1
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
REPEATS = 2


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
class Trial:
    """The truth of one trial (drive, path, reading on the fine grid) and what was recorded of it."""

    name: str
    setting: Setting
    clocks: Clocks
    drive: Drive
    reading: Floats
    path: Floats
    film: Film
    log: ServoLog


@dataclass(frozen=True)
class Campaign:
    """`identity` is the folder's name; `effects` and `world` belong in the seal."""

    identity: str
    seed: int
    eps: float
    effects: tuple[Effect, ...]
    world: World
    trials: tuple[Trial, ...]


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


def _slips(rng: np.random.Generator, plan: Plan, time: Floats, playing: np.ndarray, scale: float) -> Floats:
    """Small random body velocities (n, 3), constant for a block of time, only while the body moves."""
    block = (time[:-1] / SLIP_BLOCK_S).astype(int)
    sigma = scale * SLIP_PER_CYCLE / np.sqrt(plan.cycle_s * SLIP_BLOCK_S)
    velocity = rng.normal(0, sigma, (block[-1] + 1, 3))
    return velocity[block] * playing[:, None]


def _perform(seed: int, world: World, planned: Sequence[tuple[int, str, Setting]], slip_scale: float) -> list[Trial]:
    """Play numbered trials: simulate all, then film each."""
    drives, readings = [], []
    for number, _, s in planned:
        rng = np.random.default_rng([seed, 2, number])
        g = grid(s.plan)
        phi, reading = realise(g, world.servos)
        start = s.start + np.append(rng.uniform(-0.06, 0.06, 2), rng.normal(0, 0.05))
        drives.append(Drive(g.time, phi, g.phase, start, _slips(rng, s.plan, g.time, g.playing, slip_scale)))
        readings.append(reading)
    moved = world.paths(drives, [number for number, _, _ in planned])
    trials = []
    for (number, name, s), drive, reading, path in zip(planned, drives, readings, moved, strict=True):
        rng = np.random.default_rng([seed, 3, number])
        lead, tail = float(rng.uniform(0.6, 1.2)), float(rng.uniform(0.3, 0.6))
        clocks = Clocks(lead, float(rng.uniform(5, 500)), lead, tail)  # cameras count from their first frame
        seen = film(rng, world.cameras, drive, path, clocks)
        log = servo_log(rng, s.plan, drive, reading, world.cameras.clock_rate, clocks)
        trials.append(Trial(name, s, clocks, drive, reading, path, seen, log))
    return trials


def _hidden(seed: int, hide: str | int | Sequence[Effect], eps: float) -> tuple[tuple[Effect, ...], World]:
    rng = np.random.default_rng([seed, 1])
    if isinstance(hide, str):
        effect, world = outside.draw_outside(rng, eps, None if hide == "outside" else hide)
        return (effect,), world
    effects = catalogue.draw(rng, hide) if isinstance(hide, int) else list(hide)
    return tuple(effects), catalogue.world(eps, effects)


def make(
    seed: int,
    hide: str | int | Sequence[Effect],
    identity: str = "campaign",
    combinations: Sequence[Combination] = COMBINATIONS,
) -> Campaign:
    """`hide`: how many catalogue effects to draw, given effects, `outside`, or the name of one outside."""
    rng = np.random.default_rng([seed, 0])
    eps, slip_scale = float(np.exp(rng.uniform(np.log(0.12), np.log(0.3)))), float(np.exp(rng.uniform(-1.4, 0.4)))
    settings = _settings(rng, combinations)
    effects, world = _hidden(seed, hide, eps)
    planned = [(i * REPEATS + r, f"{s.label}-{r + 1}", s) for i, s in enumerate(settings) for r in range(REPEATS)]
    trials = _perform(seed, world, planned, slip_scale)
    return Campaign(identity, seed, eps, effects, world, tuple(trials))


def with_experiment(c: Campaign, table: Floats, cycle_s: float, start: Floats | None = None) -> Campaign:
    """The same campaign after two more trials of a new gait in the same world, perhaps from a given start pose (3,)."""
    rng = np.random.default_rng([c.seed, 0])
    rng.uniform()  # eps
    slip_scale = float(np.exp(rng.uniform(-1.4, 0.4)))
    gait = max(t.setting.gait for t in c.trials) + 1
    first = c.trials[0].setting
    plan = Plan(np.asarray(table, dtype=float), cycle_s, first.plan.pause_s, CYCLES)
    setting = Setting(f"gait{gait + 1:02d}-a", gait, first.heading, plan)
    if start is not None:
        setting = replace(setting, heading=float(start[2]), place=(float(start[0]), float(start[1])))
    planned = [(len(c.trials) + r, f"{setting.label}-{r + 1}", setting) for r in range(REPEATS)]
    new = _perform(c.seed, c.world, planned, slip_scale)
    return Campaign(c.identity, c.seed, c.eps, c.effects, c.world, (*c.trials, *new))
