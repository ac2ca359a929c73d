"""Servo faults: what a joint does in place of what it should do, equally large in every trial that has them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from blind.schedule import lagged, rate_limited
from blind.snake import Floats


@dataclass(frozen=True)
class Motion:
    """What servos would do: time (n,) [s], all joints' angles (n, m) [rad]; joint: index of the faulty one."""

    trial: int
    time: Floats
    angles: Floats
    joint: int

    @property
    def own(self) -> Floats:
        """Of the faulty joint (n,)."""
        return self.angles[:, self.joint]

    @property
    def half(self) -> int:
        """The node in the middle of the trial."""
        return len(self.time) // 2

    @property
    def late(self) -> np.ndarray:
        """The second half (n,)."""
        return np.arange(len(self.time)) >= self.half

    def lagged(self, target: Floats, lag_s: float) -> Floats:
        """A first-order lag behind `target` (n,)."""
        return lagged(self.time, target[:, None], np.full(len(self.time) - 1, lag_s))[:, 0]


Bend = Callable[[np.random.Generator, Motion], Floats]


def dies_half_way(rng: np.random.Generator, m: Motion) -> Floats:
    """It holds its place from the middle of each trial on."""
    return np.where(m.late, m.own[m.half], m.own)


def dead_every_other_trial(rng: np.random.Generator, m: Motion) -> Floats:
    """It holds its first place in the trials 1, 3, ..., and does as it is told in the others."""
    return m.own if m.trial % 2 else np.full(len(m.own), m.own[0])


def goes_limp_half_way(rng: np.random.Generator, m: Motion) -> Floats:
    """It springs back to straight from the middle of each trial on."""
    return np.where(m.late, m.own[m.half] * np.exp(-np.maximum(m.time - m.time[m.half], 0) / 0.3), m.own)


def zero_slips_half_way(rng: np.random.Generator, m: Motion) -> Floats:
    """Its horn slips on the shaft: from the middle of each trial on by one angle."""
    return m.own + rng.uniform(0.1, 0.4) * m.late


def zero_slips_once(rng: np.random.Generator, m: Motion) -> Floats:
    """Its horn slips on the shaft between two trials: from the third on by one angle."""
    return m.own + rng.uniform(0.1, 0.4) * (m.trial >= 2)


def slow_in_proportion(rng: np.random.Generator, m: Motion) -> Floats:
    """Too slow by a share of what each gait asks of it: no one speed limits all trials."""
    reach = rng.uniform(0.2, 0.6) * np.abs(np.gradient(m.own, m.time)).max()
    return rate_limited(m.time, m.own[:, None], reach)[:, 0]


def lags_more_and_more(rng: np.random.Generator, m: Motion) -> Floats:
    """Its lag grows in the course of each trial from nearly nothing."""
    lag = rng.uniform(0.2, 0.6) * np.linspace(0.02, 1, len(m.own) - 1)
    return lagged(m.time, m.own[:, None], lag)[:, 0]


def lags_in_its_gear(rng: np.random.Generator, m: Motion) -> Floats:
    """Two lags, one behind the other: a soft drive that carries a soft gear."""
    return m.lagged(m.lagged(m.own, rng.uniform(0.05, 0.2)), rng.uniform(0.05, 0.2))


def slow_one_way(rng: np.random.Generator, m: Motion) -> Floats:
    """It lifts its load slowly and lowers it as it is told."""
    reach, found = rng.uniform(0.2, 0.6) * np.abs(np.gradient(m.own, m.time)).max(), m.own.copy()
    for i, step in enumerate(np.diff(m.time) * reach):
        found[i + 1] = min(m.own[i + 1], found[i] + step)
    return found


def clipped(rng: np.random.Generator, m: Motion) -> Floats:
    """Stops on both sides keep it within a part of its swing."""
    middle = m.own.mean()
    reach = rng.uniform(0.3, 0.7) * np.abs(m.own - middle).max()
    return np.clip(m.own, middle - reach, middle + reach)


def sticks_and_slips(rng: np.random.Generator, m: Motion) -> Floats:
    """It stays until it is off by so much, then jumps to where it should be."""
    threshold, held = rng.uniform(0.05, 0.25), m.own.copy()
    for i in range(1, len(held)):
        if abs(held[i] - held[i - 1]) <= threshold:
            held[i] = held[i - 1]
    return m.lagged(held, 0.02)


def yields_to_load(rng: np.random.Generator, m: Motion) -> Floats:
    """Soft: it gives way to a load that the motion of the other joints makes, nearer ones more."""
    distance = np.abs(np.arange(m.angles.shape[1]) - m.joint)
    load = np.gradient(m.angles, m.time, axis=0) @ (rng.normal(size=len(distance)) / np.maximum(distance, 0.5))
    bent = m.own - rng.uniform(0.2, 0.8) * np.abs(m.own).max() * load / np.abs(load).max()
    return m.lagged(bent, rng.uniform(0.05, 0.2))


def weakens(rng: np.random.Generator, m: Motion) -> Floats:
    """Its swing falls to 40 % in the course of each trial."""
    return m.own * (1 - 0.6 * np.linspace(0, 1, len(m.own)))


BENDS: dict[str, Bend] = {
    f.__name__: f
    for f in (dies_half_way, dead_every_other_trial, goes_limp_half_way, zero_slips_half_way, zero_slips_once,
              slow_in_proportion, slow_one_way, lags_more_and_more, lags_in_its_gear, clipped, sticks_and_slips,
              yields_to_load, weakens)
}  # fmt: skip
# The servo does not know of it.
UNREAD: dict[str, Bend] = {f"{f.__name__}_unread": f for f in (zero_slips_half_way, zero_slips_once)}
