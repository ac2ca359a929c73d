"""Servo faults that no law of the catalogue describes, log faults (log_faults.py), and campaigns that have one.

A servo fault maps what a joint would do to what it does: the same fault, equally large, in every trial. A log fault
changes what is written down alone. Beside them stand truths, effects of the catalogue that a log should show.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from blind.campaign import Campaign, Trial, make
from blind.catalogue import Effect, ServoFault
from blind.log_faults import MISWRITES
from blind.protocol import Protocol
from blind.random_protocols import draw_protocol
from blind.schedule import lagged, rate_limited
from blind.snake import Floats

JOINTS, LEAST_HERTZ, MOST_GAITS, MOST_PLAYS = (4, 10), 12, 4, 2  # small campaigns whose log tells how a joint moves
NOTHING = "nothing"
# Parameter and ends of its size: each moves a joint by many ticks of its servo.
TRUTHS: dict[str, tuple[str, float, float]] = {
    "backlash": ("width", 0.02, 0.1),
    "gain_loss": ("loss", 0.05, 0.4),
    "loose_joint": ("width", 0.05, 0.2),
    "stuck_joint": ("angle", 0.1, 0.35),
    "servo_lag": ("lag", 0.03, 0.15),
}


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


def slow_joint(rng: np.random.Generator, m: Motion) -> Floats:
    """This one alone cannot turn as fast as it is told."""
    reach = rng.uniform(0.2, 0.6) * np.abs(np.gradient(m.own, m.time)).max()
    return rate_limited(m.time, m.own[:, None], reach)[:, 0]


def lagging_joint(rng: np.random.Generator, m: Motion) -> Floats:
    """This one alone lags."""
    return m.lagged(m.own, rng.uniform(0.1, 0.4))


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
    for f in (dies_half_way, dead_every_other_trial, goes_limp_half_way, zero_slips_half_way, slow_joint,
              lagging_joint, clipped, sticks_and_slips, yields_to_load, weakens)
}  # fmt: skip
UNREAD = "zero_slips_half_way_unread"  # the servo does not know of it


HARMLESS = (NOTHING, "log_with_lost_rows", "log_in_coarse_steps", "log_of_another_clock")  # joints follow, and it shows
FAULTS = (NOTHING, *TRUTHS, *BENDS, UNREAD, *MISWRITES)


@dataclass(frozen=True)
class Faulty:
    """A campaign with one fault; place: the joint (1 .. m) that has it."""

    fault: str
    place: int
    campaign: Campaign


def servo_fault(name: str, joint: int, seed: int) -> ServoFault:
    """What a campaign's World does with angles; the joint's index."""

    def realised(trial: int, time: Floats, angles: Floats, reading: Floats) -> tuple[Floats, Floats]:
        bend = zero_slips_half_way if name == UNREAD else BENDS[name]
        bent = angles.copy()
        bent[:, joint] = bend(np.random.default_rng([seed, 8]), Motion(trial, time, angles, joint))
        return bent, reading if name == UNREAD else bent

    return realised


def faulty(fault: str, seed: int, identity: str = "campaign") -> Faulty:
    """Everything follows from the seed."""
    protocol = small_protocol(seed)
    rng = np.random.default_rng([seed, 7])
    joint = int(rng.integers(protocol.robot.joints))
    bent = servo_fault(fault, joint, seed) if fault in (*BENDS, UNREAD) else None
    c = make(seed, _hidden(fault, joint, rng), identity, protocol=protocol, fault=bent)
    if fault in MISWRITES:
        c = replace(c, trials=tuple(_miswritten(rng, t, fault, joint) for t in c.trials))
    return Faulty(fault, joint + 1, c)


def small_protocol(seed: int) -> Protocol:
    """The first of a few random ones that has a log and few joints, cut to a few trials."""
    rng = np.random.default_rng([seed, 9])
    while True:
        p = draw_protocol(int(rng.integers(2**40)))
        if JOINTS[0] <= p.robot.joints <= JOINTS[1] and p.instruments.log_hertz > LEAST_HERTZ:
            return replace(p, plays=min(p.plays, MOST_PLAYS), settings=p.settings[:MOST_GAITS])


def _hidden(fault: str, joint: int, rng: np.random.Generator) -> list[Effect]:
    if fault not in TRUTHS:
        return []
    parameter, low, high = TRUTHS[fault]
    return [Effect(fault, None if fault == "servo_lag" else joint + 1, {parameter: float(rng.uniform(low, high))})]


def _miswritten(rng: np.random.Generator, t: Trial, fault: str, joint: int) -> Trial:
    return replace(t, log=MISWRITES[fault](rng, t.log, joint))
