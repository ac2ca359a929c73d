"""Campaigns with one servo fault that no law of the catalogue describes (bends.py), or a log fault (log_faults.py).

A log fault changes what is written down alone. Beside them stand truths, effects of the catalogue that a log or
markers should show.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from blind.bends import BENDS, UNREAD, Motion
from blind.campaign import Campaign, Trial, make
from blind.catalogue import Effect, ServoFault
from blind.log_faults import MISWRITES
from blind.protocol import Protocol
from blind.random_protocols import draw_protocol
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
    "lagging_joint": ("lag", 0.02, 0.4),
    "slow_joint": ("max_speed", 0.3, 0.95),  # of the quickest that it is told to turn
    "speed_saturation": ("max_speed", 0.3, 0.95),
    "zero_offset": ("offset", 0.02, 0.3),
    "marker_offset": ("along", 3e-3, 3e-2),  # of a robot of one metre, and to the left
}
AT_ALL = ("servo_lag", "speed_saturation")


# The law of the catalogue that comes nearest: to name it is no error, for it is the same part.
AKIN = {
    "slow_in_proportion": "slow_joint", "slow_one_way": "slow_joint", "lags_more_and_more": "lagging_joint",
    "lags_in_its_gear": "lagging_joint", **dict.fromkeys(UNREAD, "zero_offset"),
}  # fmt: skip
HARMLESS = (NOTHING, "log_with_lost_rows", "log_in_coarse_steps", "log_of_another_clock")  # joints follow, and it shows
FAULTS = (NOTHING, *TRUTHS, *BENDS, *UNREAD, *MISWRITES)


@dataclass(frozen=True)
class Faulty:
    """A campaign with one fault; place: the joint (1 .. m) that has it."""

    fault: str
    place: int
    campaign: Campaign


def servo_fault(name: str, joint: int, seed: int) -> ServoFault:
    """What a campaign's World does with angles; the joint's index."""

    def realised(trial: int, time: Floats, angles: Floats, reading: Floats) -> tuple[Floats, Floats]:
        bent = angles.copy()
        bend = (BENDS | UNREAD)[name]
        bent[:, joint] = bend(np.random.default_rng([seed, 8]), Motion(trial, time, angles, joint))
        return bent, reading if name in UNREAD else bent

    return realised


def faulty(fault: str, seed: int, identity: str = "campaign") -> Faulty:
    """Everything follows from the seed."""
    protocol = small_protocol(seed)
    rng = np.random.default_rng([seed, 7])
    joint = int(rng.integers(protocol.robot.joints))
    bent = servo_fault(fault, joint, seed) if fault in (*BENDS, *UNREAD) else None
    c = make(seed, _hidden(fault, joint, rng, protocol), identity, protocol=protocol, fault=bent)
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


def _hidden(fault: str, joint: int, rng: np.random.Generator, protocol: Protocol) -> list[Effect]:
    if fault not in TRUTHS:
        return []
    parameter, low, high = TRUTHS[fault]
    values = {parameter: float(rng.uniform(low, high))}
    if parameter == "max_speed":
        values[parameter] *= quickest(protocol, None if fault in AT_ALL else joint)
    if fault == "marker_offset":
        values = {
            name: size * protocol.robot.size * rng.choice([-1, 1])
            for size in values.values()
            for name in ("along", "left")
        }
    return [Effect(fault, None if fault in AT_ALL else joint + 1, values)]


def quickest(protocol: Protocol, joint: int | None) -> float:
    """Speed [rad/s] of the quickest set-point, of a joint (its index) or of all."""
    own = slice(None) if joint is None else [joint]
    plans = [s.plan for s in protocol.settings]
    tables = [p.table[:, own] for p in plans]
    steps = [np.abs(np.diff(t, axis=0, append=t[:1])).max() * len(t) for t in tables]
    return max(step / p.cycle_s for step, p in zip(steps, plans, strict=True))


def _miswritten(rng: np.random.Generator, t: Trial, fault: str, joint: int) -> Trial:
    return replace(t, log=MISWRITES[fault](rng, t.log, joint))
