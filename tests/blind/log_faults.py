"""Faults of servo logs: what is written down is not what the servos read, while joints do as they are told."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from blind.cameras import ServoLog
from blind.snake import Floats

Miswrite = Callable[[np.random.Generator, ServoLog, int], ServoLog]


def log_with_lost_rows(rng: np.random.Generator, log: ServoLog, joint: int) -> ServoLog:
    """Four of ten rows are lost, and a twelfth of the log in one piece."""
    kept = rng.uniform(size=len(log.time)) > 0.4
    start = int(0.3 * len(kept))
    kept[start : start + len(kept) // 12] = False
    return ServoLog(
        log.time[kept], log.cycle[kept], log.step[kept], log.phase[kept], log.command[kept], log.position[kept]
    )


def log_in_coarse_steps(rng: np.random.Generator, log: ServoLog, joint: int) -> ServoLog:
    """Positions are rounded to 0.02 rad."""
    return replace(log, position=np.round(log.position / 0.02) * 0.02)


def log_of_another_clock(rng: np.random.Generator, log: ServoLog, joint: int) -> ServoLog:
    """Its time begins elsewhere."""
    return replace(log, time=log.time + 1e4)


def log_with_two_joints_swapped(rng: np.random.Generator, log: ServoLog, joint: int) -> ServoLog:
    """The columns of the joint and of the next one."""
    order = np.arange(log.position.shape[1])
    other = (joint + 1) % len(order)
    order[[joint, other]] = other, joint
    return replace(log, position=log.position[:, order])


def log_of_joints_reversed(rng: np.random.Generator, log: ServoLog, joint: int) -> ServoLog:
    """Joints are counted from the other end."""
    return replace(log, position=log.position[:, ::-1])


def log_with_a_sign_flipped(rng: np.random.Generator, log: ServoLog, joint: int) -> ServoLog:
    """One joint turns the other way."""
    return _with(log, joint, -log.position[:, joint])


def log_stale(rng: np.random.Generator, log: ServoLog, joint: int) -> ServoLog:
    """One joint is read every eighth row, and repeated in between."""
    return _with(log, joint, log.position[np.arange(len(log.time)) // 8 * 8, joint])


def log_late(rng: np.random.Generator, log: ServoLog, joint: int) -> ServoLog:
    """One joint's reading is 0.15 s old."""
    return _with(log, joint, np.interp(log.time - 0.15, log.time, log.position[:, joint]))


def log_with_glitches(rng: np.random.Generator, log: ServoLog, joint: int) -> ServoLog:
    """One reading in fifty of a joint is zero."""
    return _with(log, joint, np.where(rng.uniform(size=len(log.time)) < 0.02, 0.0, log.position[:, joint]))


def _with(log: ServoLog, joint: int, position: Floats) -> ServoLog:
    """Other readings of one joint (R,)."""
    every = log.position.copy()
    every[:, joint] = position
    return replace(log, position=every)


MISWRITES: dict[str, Miswrite] = {
    f.__name__: f
    for f in (log_with_lost_rows, log_in_coarse_steps, log_of_another_clock, log_with_two_joints_swapped,
              log_of_joints_reversed, log_with_a_sign_flipped, log_stale, log_late, log_with_glitches)
}  # fmt: skip
