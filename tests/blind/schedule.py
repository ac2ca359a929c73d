"""From a joint table to realised joint angles on a fine time grid: the schedule and what happens in the servos.

Times are seconds since t0. The set-point is piecewise linear through the rows, or stays on a
row until the next is due; each effect is a map set-point -> angle.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from blind.snake import Floats

STEPS_PER_CYCLE = 2000


@dataclass(frozen=True)
class Plan:
    """One trial as planned: table (T, m) [rad], duration of a cycle and of the pause after it [s]; held: rows jump."""

    table: Floats
    cycle_s: float
    pause_s: float
    cycles: int
    held: bool = False


@dataclass(frozen=True)
class Grid:
    """Nodes: time (n + 1,) [s], set-points (n + 1, m), phase in cycles (n + 1,), playing (n,); held: set-points stay
    until the next node, where they jump, else they are linear between nodes."""

    time: Floats
    setpoint: Floats
    phase: Floats
    playing: np.ndarray
    held: bool = False


@dataclass(frozen=True)
class Servos:
    """Parameters of the actuation effects, neutral by default. Dictionaries: joint number -> value."""

    delay: float = 0.0
    lag: float = 0.0
    swing: tuple[float, float] | None = None  # lag [s] and damping ratio of servos with inertia
    max_speed: float = np.inf
    lags: dict[int, float] = field(default_factory=dict)
    speeds: dict[int, float] = field(default_factory=dict)
    width: dict[int, float] = field(default_factory=dict)
    loss: dict[int, float] = field(default_factory=dict)
    stuck: dict[int, float] = field(default_factory=dict)
    offset: dict[int, float] = field(default_factory=dict)
    loose: dict[int, float] = field(default_factory=dict)
    varying_lag: tuple[float, float, float] | None = None  # mean lag [s], period [s], phase [rad]


def steps_of(plan: Plan) -> int:
    """About STEPS_PER_CYCLE, a whole number a row, and no fewer than 20."""
    return max(20, STEPS_PER_CYCLE // len(plan.table)) * len(plan.table)


def grid(plan: Plan, steps_per_cycle: int = STEPS_PER_CYCLE) -> Grid:
    """Nodes that meet every row of the table; a pause gets a tenth of a cycle's steps."""
    rows = len(plan.table)
    sub = steps_per_cycle // rows
    n, rest = sub * rows, max(1, sub * rows // 10)
    cycle_phase = np.arange(n + 1) / n
    closed = np.concatenate([plan.table, plan.table[:1]])
    position = np.minimum(cycle_phase * rows, rows - 1e-12)
    row = position.astype(int)
    row[np.arange(n + 1) % sub == 0] = np.minimum(np.arange(rows + 1), rows - 1)  # exact at the rows
    part = (cycle_phase * rows - row)[:, None]
    played = closed[row] if plan.held else closed[row] * (1 - part) + closed[row + 1] * part
    if plan.held:
        played[-1] = closed[0]
    time, phase, points, playing = [np.zeros(1)], [np.zeros(1)], [closed[:1]], []
    for k in range(plan.cycles):
        start = k * (plan.cycle_s + plan.pause_s)
        time += [start + cycle_phase[1:] * plan.cycle_s]
        phase += [k + cycle_phase[1:]]
        points += [played[1:]]
        playing += [np.ones(n, dtype=bool)]
        if plan.pause_s > 0:
            time += [start + plan.cycle_s + np.arange(1, rest + 1) / rest * plan.pause_s]
            phase += [np.full(rest, k + 1.0)]
            points += [np.repeat(closed[:1], rest, axis=0)]
            playing += [np.zeros(rest, dtype=bool)]
    parts = (np.concatenate(x) for x in (time, points, phase, playing))
    return Grid(*parts, held=plan.held)


def lagged(time: Floats, target: Floats, lag: Floats, held: bool = False) -> Floats:
    """q' = (target - q) / lag, exact for a target that is linear between nodes, or held until the next; lag per step
    (n,)."""
    q = np.empty_like(target)
    q[0] = target[0]
    h = np.diff(time)
    slope = np.zeros_like(target[1:]) if held else np.diff(target, axis=0) / h[:, None]
    decay = np.exp(-h / lag)
    for i in range(len(h)):
        behind, there = lag[i] * slope[i], target[i if held else i + 1]
        q[i + 1] = there - behind + (q[i] - target[i] + behind) * decay[i]
    return q


def swung(time: Floats, target: Floats, lag: float, damping: float, held: bool = False) -> Floats:
    """(lag / 2 damping)^2 q'' + lag q' + q = target, from rest: two modes, exact for a target as in `lagged`."""
    one, two = np.roots([(lag / (2 * damping)) ** 2, lag, 1.0]).astype(complex)
    q, rate = np.empty_like(target), np.zeros(target.shape[1])
    q[0] = target[0]
    h = np.diff(time)
    slope = np.zeros_like(target[1:]) if held else np.diff(target, axis=0) / h[:, None]
    for i in range(len(h)):
        there = target[i if held else i + 1]
        away, speed = q[i] - target[i] + lag * slope[i], rate - slope[i]
        first = (speed - two * away) / (one - two)
        modes = first * np.exp(one * h[i]), (away - first) * np.exp(two * h[i])
        q[i + 1] = there - lag * slope[i] + (modes[0] + modes[1]).real
        rate = slope[i] + (one * modes[0] + two * modes[1]).real
    return q


def delayed(time: Floats, target: Floats, delay: float, held: bool = False) -> Floats:
    """q(t) = target(t - delay), at rest on the first row before."""
    if held:
        return target[np.maximum(np.searchsorted(time, time - delay, side="right") - 1, 0)]
    return np.column_stack([np.interp(time - delay, time, column) for column in target.T])


def rate_limited(time: Floats, target: Floats, max_speed: float, held: bool = False) -> Floats:
    q = np.empty_like(target)
    q[0] = target[0]
    for i, reach in enumerate(np.diff(time) * max_speed):
        q[i + 1] = q[i] + np.clip(target[i if held else i + 1] - q[i], -reach, reach)
    return q


def _play(target: Floats, width: float, begun: float) -> Floats:
    """The play operator for one joint: stays until the target has crossed the gap, then follows at its edge. begun:
    where in the gap it lies at first, between -1/2 and 1/2 of it."""
    q = np.empty_like(target)
    q[0] = target[0] + begun * width
    for i in range(1, len(target)):
        q[i] = min(max(q[i - 1], target[i] - width / 2), target[i] + width / 2)
    return q


def realise(g: Grid, servos: Servos, begun: Floats | None = None) -> tuple[Floats, Floats]:
    """True joint angles and what the servos read (before rounding), both (n + 1, m). begun: where every joint (m,) lies
    in its gap at first, as a share of it; in the middle."""
    begun = np.zeros(g.setpoint.shape[1]) if begun is None else begun
    q, jumps = g.setpoint.copy(), np.full(g.setpoint.shape[1], g.held)  # what has followed jumps does not jump
    if servos.delay > 0:
        q = delayed(g.time, q, servos.delay, g.held)
    for joint, lag in servos.lags.items():
        q[:, [joint - 1]] = lagged(g.time, q[:, [joint - 1]], np.full(len(g.time) - 1, lag), g.held)
        jumps[joint - 1] = False
    if servos.swing is not None:
        for j, own in enumerate(jumps):
            q[:, [j]] = swung(g.time, q[:, [j]], *servos.swing, held=bool(own))
        jumps[:] = False
    if servos.lag > 0:
        for j, own in enumerate(jumps):
            q[:, [j]] = lagged(g.time, q[:, [j]], np.full(len(g.time) - 1, servos.lag), bool(own))
        jumps[:] = False
    if servos.varying_lag is not None:
        mean, period, phase = servos.varying_lag
        middle = (g.time[1:] + g.time[:-1]) / 2
        q = lagged(g.time, q, mean * (1.02 + np.sin(2 * np.pi * middle / period + phase)), bool(jumps.any()))
        jumps[:] = False
    for joint, speed in servos.speeds.items():
        q[:, [joint - 1]] = rate_limited(g.time, q[:, [joint - 1]], speed, bool(jumps[joint - 1]))
        jumps[joint - 1] = False
    if np.isfinite(servos.max_speed):
        for j, own in enumerate(jumps):
            q[:, [j]] = rate_limited(g.time, q[:, [j]], servos.max_speed, bool(own))
    for joint, width in servos.width.items():
        q[:, joint - 1] = _play(q[:, joint - 1], width, begun[joint - 1])
    for joint, loss in servos.loss.items():
        q[:, joint - 1] *= 1 - loss
    for joint, angle in servos.stuck.items():
        q[:, joint - 1] = angle
    reading = q
    q = q.copy()  # from here on the servos know nothing of it
    for joint, offset in servos.offset.items():
        q[:, joint - 1] += offset
    for joint, width in servos.loose.items():
        q[:, joint - 1] = _play(q[:, joint - 1], width, begun[joint - 1])
    return q, reading
