"""One trial: the robot is set down, a joint table is played with pauses, and everything is recorded without noise."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from serpenoid.arena.floor import Mats
from serpenoid.arena.protocol import Protocol
from serpenoid.arena.robot import TICK
from serpenoid.arena.world import World
from serpenoid.body import Floats

LEAD_S = 1.2  # cameras run before the first step
TRAIL_S = 0.5  # and after the last pause


@dataclass(frozen=True)
class Plan:
    """One line of the campaign: `heading_deg` and `number` decide how the robot is set down."""

    name: str
    gait: str
    cycle_duration_s: float
    number: int
    heading_deg: float


@dataclass(frozen=True)
class Command:
    """Sent at `time_s` after the first step; `row` of the table, counted as `step` (T: row 0 again)."""

    time_s: float
    phase: str
    cycle: int
    step: int
    row: int


@dataclass(frozen=True)
class Recording:
    """The noise-free truth. S time steps, F frames; time zero is the cameras' first frame.

    `time_s` (S,), `angles` (S, m) servo readings, `duty` (S, m), `power_W` (S,), `voltage_V` (S,),
    `command` (S,) index into `commands`; `frame_s` (F,), `markers` (F, N, 3) z up, `loads` (F, N) [N].
    """

    commands: tuple[Command, ...]
    time_s: Floats
    angles: Floats
    duty: Floats
    power_W: Floats
    voltage_V: Floats
    command: NDArray[np.int64]
    frame_s: Floats
    markers: Floats
    loads: Floats


def plans(protocol: Protocol) -> list[Plan]:
    """All trials, repeats outermost, as one would rather spread them over the day."""
    result = []
    for number in range(protocol.trials):
        for gait in protocol.gait:
            durations = gait.cycle_durations_s or (protocol.cycle_duration_s,)
            headings = gait.headings_deg or protocol.start.headings_deg
            for index, duration in enumerate(durations):
                letter = f"-{chr(ord('a') + index)}" if len(durations) > 1 else ""
                name = f"{gait.name}{letter}-{number + 1}"
                result.append(Plan(name, gait.name, duration, number, headings[number % len(headings)]))
    return result


def schedule(rows: int, duration_s: float, cycles: int, pause_s: float) -> tuple[Command, ...]:
    """All commands of a trial, beginning with the approach to row 0 before the first step."""
    commands = [Command(-math.inf, "approach", 0, 0, 0)]
    for cycle in range(cycles):
        begin = cycle * (duration_s + pause_s)
        commands += [Command(begin + i * duration_s / rows, "play", cycle, i, i) for i in range(rows)]
        commands.append(Command(begin + duration_s, "pause", cycle, rows, 0))
    end = cycles * (duration_s + pause_s)
    return (*commands, Command(end, "end", cycles - 1, rows, 0))


def randomness(protocol: Protocol, plan: Plan, purpose: int) -> np.random.Generator:
    """Independent numbers for each trial and purpose, the same on every run."""
    return np.random.default_rng([protocol.seed, purpose, *plan.name.encode()])


def play(protocol: Protocol, plan: Plan, table: Floats) -> Recording:
    """Run one trial in the arena."""
    random = randomness(protocol, plan, 2)
    floor, start = protocol.floor, protocol.start
    laid = protocol.seed if floor.seed is None else floor.seed
    mats = Mats.laid(laid, floor.variation, random.normal(0, floor.trial_variation))
    world = World(protocol.robot.assembled(), mats)
    x, y = random.normal(0, start.position_sd_m, 2) if start.position_sd_m else (0.0, 0.0)
    heading = math.radians(plan.heading_deg + random.normal(0, start.heading_sd_deg))
    world.place(table[0], x, y, heading)
    commands = schedule(len(table), plan.cycle_duration_s, protocol.cycles, protocol.pause_s)
    return _record(world, table, commands, protocol.cameras.frames_per_second)


def _record(world: World, table: Floats, commands: tuple[Command, ...], frames_per_second: float) -> Recording:
    timestep = world.robot.timestep_s
    steps = math.ceil((LEAD_S + commands[-1].time_s + TRAIL_S) / timestep)
    time: Floats = np.arange(steps, dtype=np.float64) * timestep
    sent = np.zeros(steps, dtype=np.int64)
    angles, duty = np.zeros((steps, world.robot.servos)), np.zeros((steps, world.robot.servos))
    power, voltage = np.zeros(steps), np.zeros(steps)
    frames = math.floor(time[-1] * frames_per_second) + 1
    markers, loads = np.zeros((frames, world.robot.wheels, 3)), np.zeros((frames, world.robot.wheels))
    index, frame = 0, 0
    for step in range(steps):
        while index + 1 < len(commands) and commands[index + 1].time_s <= time[step] - LEAD_S + timestep / 2:
            index += 1
            world.command(table[commands[index].row])
        sent[step], angles[step], duty[step] = index, world.angles(), world.duty()
        power[step], voltage[step] = world.power(), world.voltage()
        if frame < frames and time[step] >= frame / frames_per_second - timestep / 2:
            markers[frame], loads[frame] = world.markers(), world.wheel_loads()
            frame += 1
        world.step()
    frame_times: Floats = np.arange(frames, dtype=np.float64) / frames_per_second
    return Recording(commands, time, angles, duty, power, voltage, sent, frame_times, markers, loads)


def commanded_angles(recording: Recording, table: Floats) -> Floats:
    """Angles as they went over the bus, in whole ticks, shape (S, m) [rad]."""
    rows = np.array([command.row for command in recording.commands])
    return np.round(table[rows[recording.command]] / TICK) * TICK
