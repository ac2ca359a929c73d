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
    h = np.diff(time)
    slope = np.zeros_like(target[1:]) if held else np.diff(target, axis=0) / h[:, None]
    behind, decay = lag[:, None] * slope, np.exp(-h / lag).tolist()
    ends = (target[:-1] if held else target[1:]) - behind
    return np.column_stack([_decayed(*column, decay) for column in zip(target.T, behind.T, ends.T, strict=True)])


def _decayed(target: Floats, behind: Floats, ends: Floats, decay: list[float]) -> list[float]:
    """For one joint, step by step in floats, which takes a tenth of the time that arrays of one number take."""
    q = target[:1].tolist()
    for start, back, end, left in zip(target.tolist(), behind.tolist(), ends.tolist(), decay, strict=False):
        q.append(end + (q[-1] - start + back) * left)
    return q


def swung(time: Floats, target: Floats, lag: float, damping: float, held: bool = False) -> Floats:
    """(lag / 2 damping)^2 q'' + lag q' + q = target, from rest: two modes, exact for a target as in `lagged`."""
    one, two = np.roots([(lag / (2 * damping)) ** 2, lag, 1.0]).astype(complex).tolist()
    h = np.diff(time)
    slope = np.zeros_like(target[1:]) if held else np.diff(target, axis=0) / h[:, None]
    ends = (target[:-1] if held else target[1:]) - lag * slope
    first, second = np.exp(one * h).tolist(), np.exp(two * h).tolist()
    q = np.empty_like(target)
    q[0] = target[0]
    for j in range(target.shape[1]):
        now, rate = target[0, j].item(), 0.0
        steps = zip(*(c[:, j].tolist() for c in (target[:-1], slope, ends)), first, second, strict=True)
        for i, (start, ramp, end, faded, gone) in enumerate(steps):
            away, speed = now - start + lag * ramp, rate - ramp
            share = (speed - two * away) / (one - two)
            modes = share * faded, (away - share) * gone
            now, rate = end + (modes[0] + modes[1]).real, ramp + (one * modes[0] + two * modes[1]).real
            q[i + 1, j] = now
    return q


def delayed(time: Floats, target: Floats, delay: float, held: bool = False) -> Floats:
    """q(t) = target(t - delay), at rest on the first row before."""
    if held:
        return target[np.maximum(np.searchsorted(time, time - delay, side="right") - 1, 0)]
    return np.column_stack([np.interp(time - delay, time, column) for column in target.T])


def rate_limited(time: Floats, target: Floats, max_speed: float, held: bool = False) -> Floats:
    ends, reach = target[:-1] if held else target[1:], (np.diff(time) * max_speed).tolist()
    columns = []
    for begun, column in zip(target[0].tolist(), ends.T.tolist(), strict=True):
        q = [begun]
        for end, far in zip(column, reach, strict=True):
            q.append(q[-1] + min(max(end - q[-1], -far), far))
        columns.append(q)
    return np.array(columns).T


def _play(target: Floats, width: float, begun: float) -> Floats:
    """The play operator for one joint: stays until the target has crossed the gap, then follows at its edge. begun:
    where in the gap it lies at first, between -1/2 and 1/2 of it."""
    q = [float(target[0] + begun * width)]
    for there in target[1:].tolist():
        q.append(min(max(q[-1], there - width / 2), there + width / 2))
    return np.array(q)


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
