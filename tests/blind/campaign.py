"""A campaign in memory: gaits, trials, and what cameras and servos saw of them; everything follows from one seed.

Separate random streams for gaits, effects, slips and cameras: with the same seed, a campaign with an effect differs
from the one without by the effect alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from blind import catalogue, outside
from blind.cameras import Clocks, Film, ServoLog, film, servo_log
from blind.catalogue import Effect, ServoFault, World
from blind.ground import Ground
from blind.motion import Drive
from blind.protocol import COMBINATIONS, REPEATS, Combination, Protocol, Setting, usual
from blind.schedule import Plan, grid, realise, steps_of
from blind.snake import Floats

SLIP_PER_CYCLE = np.array([1e-3, 0.8e-3, 2.5e-3])  # m forwards, m sideways, rad: standard deviations
SLIP_BLOCK_S = 0.1
WEATHER = (0.005, 0.05)  # SD of ln eps and of the wheels' drag from trial to trial
Hide = str | int | Sequence[Effect]


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
    """`identity` is the folder's name; `effects`, `base` (there, but no news) and `world` belong in the seal."""

    identity: str
    seed: int
    protocol: Protocol
    effects: tuple[Effect, ...]
    world: World
    trials: tuple[Trial, ...]
    base: tuple[Effect, ...] = ()

    @property
    def eps(self) -> float:
        return self.protocol.eps

    @property
    def law(self) -> World:
        """The world as trials have it in the mean."""
        return replace(self.world, weather=None)


def _slips(rng: np.random.Generator, plan: Plan, time: Floats, playing: np.ndarray, scale: float) -> Floats:
    """Small random body velocities (n, 3), constant for a block of time, only while the body moves."""
    block = (time[:-1] / SLIP_BLOCK_S).astype(int)
    sigma = scale * SLIP_PER_CYCLE / np.sqrt(plan.cycle_s * SLIP_BLOCK_S)
    velocity = rng.normal(0, sigma, (block[-1] + 1, 3))
    return velocity[block] * playing[:, None]


def _perform(
    seed: int, world: World, planned: Sequence[tuple[int, str, Setting]], protocol: Protocol, chance: Sequence[int]
) -> list[Trial]:
    """Play numbered trials: simulate all, then film each."""
    drives, readings, size, tools = [], [], protocol.robot.size, protocol.instruments
    for number, _, s in planned:
        rng = np.random.default_rng([seed, 2, number, *chance])
        g = grid(s.plan, steps_of(s.plan))
        gaps = np.random.default_rng([seed, 5, number, *chance]).uniform(-0.5, 0.5, protocol.robot.joints)
        phi, reading = realise(g, world.servos, gaps)
        if world.fault is not None:
            phi, reading = world.fault(number, g.time, phi, reading)
        start = s.start + np.append(size * rng.uniform(-0.06, 0.06, 2), rng.normal(0, 0.05))
        slips = _slips(rng, s.plan, g.time, g.playing, protocol.slip_scale) * [size, size, 1.0]
        drives.append(Drive(g.time, phi, g.phase, start, slips))
        readings.append(reading)
    moved = world.paths(drives, [number for number, _, _ in planned])
    trials = []
    for (number, name, s), drive, reading, path in zip(planned, drives, readings, moved, strict=True):
        rng = np.random.default_rng([seed, 3, number, *chance])
        lead, tail = float(rng.uniform(0.6, 1.2)), float(rng.uniform(0.3, 0.6))
        clocks = Clocks(lead, float(rng.uniform(5, 500)), lead, tail)  # cameras count from their first frame
        seen = film(rng, world.cameras, drive, path, clocks, tools, protocol.robot)
        log = servo_log(rng, s.plan, drive, reading, world.cameras.clock_rate, clocks, tools.log_hertz)
        trials.append(Trial(name, s, clocks, drive, reading, path, seen, log))
    return trials


def _weather(seed: int, chance: Sequence[int], ground: Ground, trial: int) -> Ground:
    """The floor of one trial; how much trials differ is the campaign's."""
    size = float(np.exp(np.random.default_rng([seed, 9]).uniform(*np.log(WEATHER))))
    rng = np.random.default_rng([seed, 10, trial, *chance])
    eps = ground.eps * float(np.exp(rng.normal(0, size)))
    more = ground.robot.weights * rng.normal(0, size, ground.robot.vertices)
    share = {v: ground.share.get(v, 0.0) + float(extra) for v, extra in enumerate(more)}
    return replace(ground, eps=eps, share=share)


def _hidden(
    seed: int, hide: Hide, protocol: Protocol, base: Sequence[Effect], among: Sequence[str] | None
) -> tuple[tuple[Effect, ...], World]:
    rng = np.random.default_rng([seed, 1])
    if isinstance(hide, str):
        effect, world = outside.draw_outside(rng, protocol.eps, None if hide == "outside" else hide, protocol.robot)
        return (effect,), world
    effects = catalogue.draw(rng, hide, protocol.robot, among) if isinstance(hide, int) else list(hide)
    return tuple(effects), catalogue.world(protocol.eps, [*base, *effects], protocol.robot)


def make(
    seed: int,
    hide: Hide,
    identity: str = "campaign",
    combinations: Sequence[Combination] = COMBINATIONS,
    protocol: Protocol | None = None,
    base: Sequence[Effect] = (),
    among: Sequence[str] | None = None,
    chance: Sequence[int] = (),
    fault: ServoFault | None = None,
    weather: bool = False,
) -> Campaign:
    """`hide`: how many catalogue effects to draw (`among`: some), given effects, `outside`, or the name of one outside.

    protocol: by default the usual one of this seed. base: effects that are there and no news. chance: numbers that make
    slips, hands and noise others than those of the same campaign without them. fault: of servos, beside the effects.
    weather: in each trial eps and what each wheel weighs in the drag are a little different, all through the trial.
    """
    protocol = protocol or usual(seed, combinations)
    effects, world = _hidden(seed, hide, protocol, base, among)
    world = replace(world, fault=fault, weather=partial(_weather, seed, chance) if weather else None)
    settings = [_played(s, protocol, world) for s in protocol.settings]
    plays = protocol.plays
    planned = [(i * plays + r, f"{s.label}-{r + 1}", s) for i, s in enumerate(settings) for r in range(plays)]
    trials = _perform(seed, world, planned, protocol, chance)
    return Campaign(identity, seed, protocol, effects, world, tuple(trials), tuple(base))


def _played(setting: Setting, protocol: Protocol, world: World) -> Setting:
    """Rows jump only where the servos need time to follow: no joint does in no time."""
    servos = world.servos
    slow = servos.lag > 0 or servos.swing is not None or np.isfinite(servos.max_speed)
    return replace(setting, plan=replace(setting.plan, held=True)) if protocol.held and slow else setting


def with_experiment(c: Campaign, table: Floats, cycle_s: float, start: Floats | None = None) -> Campaign:
    """The same campaign after two more trials of a new gait in the same world, perhaps from a given start pose (3,)."""
    gait = max(t.setting.gait for t in c.trials) + 1
    first = c.trials[0].setting
    plan = replace(first.plan, table=np.asarray(table, dtype=float), cycle_s=cycle_s)
    setting = Setting(f"gait{gait + 1:02d}-a", gait, first.heading, plan)
    if start is not None:
        setting = replace(setting, heading=float(start[2]), place=(float(start[0]), float(start[1])))
    planned = [(len(c.trials) + r, f"{setting.label}-{r + 1}", setting) for r in range(REPEATS)]
    new = _perform(c.seed, c.world, planned, c.protocol, ())
    return replace(c, trials=(*c.trials, *new))
