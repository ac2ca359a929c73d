"""What cameras and servos report of a motion: observation effects, then noise, gaps, ticks and clocks.

Order: marker displaced on the body, camera frame drifts, camera stretched, wrong length scale, jumps across gaps,
noise, occlusion.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from blind.motion import Drive
from blind.schedule import Plan
from blind.snake import SNAKE10, TICK, Floats, Robot, vertices

FRAMES_PER_SECOND = 120.0
MARKER_NOISE = 0.2e-3  # m


@dataclass(frozen=True)
class Cameras:
    """Parameters of the observation effects, neutral by default. `moved_marker`: vertex -> (along, left) [m] of the
    edge on its tail side; `moved_ahead`: of that on its head side; `swaying`: vertex -> to the left by the
    bend [m/rad]; `stretch`: by which share along x is longer than along y, and 45 degrees than across."""

    moved_marker: dict[int, tuple[float, float]] = field(default_factory=dict)
    moved_ahead: dict[int, tuple[float, float]] = field(default_factory=dict)
    swaying: dict[int, float] = field(default_factory=dict)
    scale_error: float = 0.0
    stretch: tuple[float, float] = (0.0, 0.0)
    clock_rate: float = 0.0
    jump: float = 0.0
    drift: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Instruments:
    """Frames per second, marker noise [m], log rows per second (0: no log), holes per marker and second, markers that
    no camera ever sees."""

    frames_per_second: float = FRAMES_PER_SECOND
    marker_noise: float = MARKER_NOISE
    log_hertz: float = 60.0
    holes: float = 0.08
    unseen: tuple[int, ...] = ()


@dataclass(frozen=True)
class Clocks:
    """Camera and servo clock at t0 [s], lead before t0 and tail after the schedule [s]."""

    camera_t0: float
    servo_t0: float
    lead: float
    tail: float


@dataclass(frozen=True)
class Film:
    """time (F,) [s since t0], markers (F, N, 2) [m] with NaN where occluded, jumps (F, 2) [m] added at gaps."""

    time: Floats
    markers: Floats
    jumps: Floats


@dataclass(frozen=True)
class ServoLog:
    """time (R,) [s on the servo clock], cycle, step (R,), phase names, command and position (R, m) [rad]."""

    time: Floats
    cycle: np.ndarray
    step: np.ndarray
    phase: np.ndarray
    command: Floats
    position: Floats


def resample(time: Floats, nodes: Floats, values: Floats) -> Floats:
    """Columns of `values` at `time`, linear between nodes, held outside."""
    return np.column_stack([np.interp(time, nodes, column) for column in values.T])


def displaced(cameras: Cameras, p: Floats) -> Floats:
    """Where markers are on a body with vertices p (F, N, 2)."""
    seen = p.copy()
    behind = [(vertex, max(vertex - 1, 0), moved) for vertex, moved in cameras.moved_marker.items()]
    ahead = [(vertex, vertex, moved) for vertex, moved in cameras.moved_ahead.items()]
    for vertex, edge, (along, left) in behind + ahead:
        e = p[:, edge + 1] - p[:, edge]
        e = e / np.linalg.norm(e, axis=-1, keepdims=True)
        seen[:, vertex] += along * e + left * np.stack([-e[:, 1], e[:, 0]], axis=-1)
    heading = np.unwrap(np.arctan2(*np.moveaxis(np.diff(p, axis=1), 2, 0)[::-1]), axis=1)  # of the edges
    for vertex, sway in cameras.swaying.items():
        joint = min(max(vertex, 1), p.shape[1] - 2)
        across = heading[:, [max(vertex - 1, 0), min(vertex, p.shape[1] - 2)]].mean(axis=1) + np.pi / 2
        bend = heading[:, joint] - heading[:, joint - 1]
        seen[:, vertex] += (sway * bend)[:, None] * np.stack([np.cos(across), np.sin(across)], axis=-1)
    return seen


def seen_markers(
    cameras: Cameras, phi: Floats, pose: Floats, time: Floats, jumps: Floats, robot: Robot = SNAKE10
) -> Floats:
    """Noise-free marker positions (F, N, 2)."""
    seen = displaced(cameras, vertices(phi, pose, robot))
    seen += np.maximum(time, 0)[:, None, None] * np.array(cameras.drift)
    return stretched(cameras, seen) * (1 + cameras.scale_error) + jumps[:, None, :]


def stretched(cameras: Cameras, points: Floats, back: int = 1) -> Floats:
    """Points (.., 2) as a camera shows them whose axes differ; back: -1 undoes it."""
    longer, shear = cameras.stretch
    x, y = points[..., 0], points[..., 1]
    if back < 0:
        size = 1 - (longer**2 + shear**2) / 4
        longer, shear, x, y = -longer, -shear, x / size, y / size
    return np.stack([x + (longer * x + shear * y) / 2, y + (shear * x - longer * y) / 2], axis=-1)


def _gaps(rng: np.random.Generator, time: Floats, count: int, i: Instruments) -> tuple[np.ndarray, np.ndarray]:
    """Which markers are missing (F, N), and the frame at which the one gap of all markers ends."""
    missing = np.zeros((len(time), count), dtype=bool)
    for vertex in range(count):
        for _ in range(rng.poisson(i.holes * (time[-1] - time[0]))):
            start = rng.integers(len(time))
            missing[start : start + int(rng.exponential(0.15) * i.frames_per_second) + 1, vertex] = True
    start = int(rng.uniform(0.2, 0.8) * len(time))
    end = start + int(rng.uniform(0.08, 0.3) * i.frames_per_second)
    missing[start:end] = True
    missing[:, list(i.unseen)] = True
    return missing, np.array([end])


def film(
    rng: np.random.Generator,
    cameras: Cameras,
    drive: Drive,
    path: Floats,
    clocks: Clocks,
    instruments: Instruments = Instruments(),
    robot: Robot = SNAKE10,
) -> Film:
    """Markers from before t0 until after the end."""
    rate = instruments.frames_per_second
    first = -clocks.lead + rng.uniform(0, 1 / rate)
    time = np.arange(first, drive.time[-1] + clocks.tail, 1 / rate)
    missing, ends = _gaps(rng, time, robot.vertices, instruments)
    directions = rng.uniform(0, 2 * np.pi, len(ends))
    jumps = np.zeros((len(time), 2))
    for end, direction in zip(ends, directions, strict=True):
        jumps[end:] += cameras.jump * np.array([np.cos(direction), np.sin(direction)])
    phi, pose = resample(time, drive.time, drive.phi), resample(time, drive.time, path)
    seen = seen_markers(cameras, phi, pose, time, jumps, robot)
    seen += rng.normal(0, instruments.marker_noise, seen.shape)
    seen[missing] = np.nan
    return Film(time, seen, jumps)


def servo_log(
    rng: np.random.Generator,
    plan: Plan,
    drive: Drive,
    reading: Floats,
    rate: float,
    clocks: Clocks,
    hertz: float = 60.0,
) -> ServoLog:
    """Rows at a slightly irregular pace; positions in ticks with a flicker of the last one."""
    count = int((drive.time[-1] + clocks.lead + clocks.tail) * hertz)
    time = -clocks.lead + (np.arange(count) + rng.uniform(-0.2, 0.2, count)) / hertz
    rows, period = len(plan.table), plan.cycle_s + plan.pause_s
    cycle = np.clip(np.floor(time / period), 0, plan.cycles - 1).astype(int)
    into = time - cycle * period
    step = np.clip(np.floor(into / plan.cycle_s * rows), 0, rows).astype(int)
    phase = np.where(step == rows, "pause", "play").astype("<U8")
    phase[time < 0], phase[time > drive.time[-1]] = "approach", "end"
    flicker = rng.normal(0, 0.4 * TICK, (count, reading.shape[1]))
    position = np.round((resample(time, drive.time, reading) + flicker) / TICK) * TICK
    return ServoLog(clocks.servo_t0 + (1 + rate) * time, cycle, step, phase, plan.table[step % rows], position)
