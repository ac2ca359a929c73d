"""From commanded to realised joint angles: the actuation effects, joint by joint, step by step.

Legend: R rows, T rows of a joint table, m joints, P coordinates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Floats
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.catalogue import actuation_effects
from serpenoid.errors import InputError
from serpenoid.mechanics.servo import dead_time, joint_sensitivity, memories, play
from serpenoid.model import Model

CHUNK = 1000  # steps evaluated in one call
CYCLES = 2000  # a memory that has not faded by then is reported
FADED = 1e-14
RESTED_S = 1e9  # on the first row before a trial: whatever follows is there


@dataclass(frozen=True)
class Realised:
    """True joint angles and what servos read of them (R, m) [rad]; zero offsets and loose joints are not read."""

    angles: Floats
    readings: Floats


def realise(model: Model, setpoints: Floats, times: Floats) -> Realised:
    """A trial that begins at rest on the first row: set-points (R, m) [rad] at `times` (R,) [s], linear in between."""
    return realise_all(model, [setpoints], [times])[0]


def realise_all(
    model: Model, setpoints: Sequence[Floats], times: Sequence[Floats], came_from: Sequence[Floats] | None = None
) -> list[Realised]:
    """Several trials. came_from: angles (m,) [rad] from which each trial came to rest on its first row, which gaps that
    were not crossed then remember; else that row."""
    if not model.actuation_effects:
        return [Realised(s, s) for s in setpoints]
    theta = coordinates(model)
    begun = [s[0] for s in setpoints] if came_from is None else came_from
    return [_played(theta, *of_trial) for of_trial in zip(setpoints, times, begun, strict=True)]


def readings_of_each(
    models: Sequence[Model], setpoints: Sequence[Floats], times: Sequence[Floats], came_from: Sequence[Floats],
    some: slice = slice(None),
) -> list[list[Floats]]:  # fmt: skip
    """The readings (R, m) of several trials by each of several models, of all joints or of some: side by side, which
    takes little longer than one joint alone, and once of joints that do the same in several models."""
    setpoints, came_from = [s[:, some] for s in setpoints], [c[some] for c in came_from]
    found = [list(setpoints) for _ in models]
    thetas = {n: coordinates(model)[:, some] for n, model in enumerate(models) if model.actuation_effects}
    for late in {late_by(theta) for theta in thetas.values()}:
        columns: dict[tuple[int, bytes], int] = {}  # by joint and coordinates
        places = {
            n: [columns.setdefault((j, own.tobytes()), len(columns)) for j, own in enumerate(theta.T)]
            for n, theta in thetas.items()
            if late_by(theta) == late
        }
        joints = [j for j, _ in columns]
        theta = np.ascontiguousarray(np.transpose([np.frombuffer(own) for _, own in columns]))
        for trial, (asked, time, rested) in enumerate(zip(setpoints, times, came_from, strict=True)):
            rows, durations, at = _rows(asked, time, late)
            memory = np.tile(rested[joints], (memories(), 1))
            read = {n: np.empty((len(durations), asked.shape[1])) for n in places}
            for first in range(0, len(durations), CHUNK):  # large arrays are new memory every time, and slow
                part, told = slice(first, first + CHUNK), rows[first : first + CHUNK + 1].take(joints, axis=1)
                _, readings, memory = play(memory, told, durations[part], theta)
                for n, place in places.items():
                    read[n][part] = readings.take(place, axis=1)
            for n in places:
                found[n][trial] = read[n] if at is None else read[n][at]
    return found


def _played(theta: Floats, setpoints: Floats, times: Floats, rested: Floats) -> Realised:
    """Joints with coordinates theta (P, m), told set-points (R, m), that came to rest from angles (m,)."""
    rows, durations, at = _rows(setpoints, times, late_by(theta))
    angles, readings, _ = play(np.tile(rested, (memories(), 1)), rows, durations, theta)
    return Realised(angles, readings) if at is None else Realised(angles[at], readings[at])


def _rows(setpoints: Floats, times: Floats, late: float) -> tuple[Floats, Floats, NDArray[np.int64] | None]:
    """What servos are told that are so late [s], after a first step on the spot, which gives the first row's angles;
    durations of the steps; and at which of them `times` are, if not at all."""
    delayed = late and len(times) > 1
    told, mesh, at = asked_earlier(setpoints, times, late) if delayed else (setpoints, times, None)
    return np.concatenate([told[:1], told]), np.concatenate([[RESTED_S], np.diff(mesh)]), at


def late_by(theta: Floats) -> float:
    """By how much later [s] servos with coordinates theta (P, m) do what they do: all joints alike."""
    return float(dead_time(theta.max(axis=1)))


def asked_earlier(setpoints: Floats, times: Floats, late: float) -> tuple[Floats, Floats, NDArray[np.int64]]:
    """Set-points (K, m) on a finer mesh (K,) [s], and the nodes (R,) at which servos do what they do so much later [s]
    at `times` (R,): their laws do not know the time, and they begin at rest."""
    count, earlier = len(times), np.maximum(times - late, times[0])
    every = np.concatenate([earlier, times])
    order = np.argsort(every, kind="stable")  # which merges what is sorted already
    every = every[order]
    new = np.append(True, every[1:] > every[:-1])
    mesh, last = every[new], np.append(new[1:], True)
    row = np.minimum(np.cumsum(order >= count)[last] - 1, count - 2)
    told, following = setpoints.take(row, axis=0), setpoints.take(row + 1, axis=0)
    told += ((mesh - times[row]) / (times[row + 1] - times[row]))[:, None] * (following - told)
    at = np.empty(len(every), dtype=np.int64)
    at[order] = np.cumsum(new) - 1
    return told, mesh, at[:count]


def asked_rows(table: Floats, rows: float) -> Floats:
    """What a joint table (T, m), played again and again, asks of servos that are so many rows late, at each row: on
    straight lines between rows."""
    whole = int(np.floor(rows))
    part = rows - whole
    return np.asarray((1 - part) * np.roll(table, whole, axis=0) + part * np.roll(table, whole + 1, axis=0))


def realise_gait(model: Model, table: Floats) -> Floats:
    """The periodic motion (T, m) on which a joint table, played again and again, settles; row 0 stays row 0."""
    if not model.actuation_effects:
        return table
    theta, row_s = coordinates(model), model.step_duration(len(table))
    late = late_by(theta)
    table = asked_rows(table, late / row_s) if late else table
    closed, durations = np.concatenate([table, table[:1]]), np.full(len(table), row_s)
    memory = np.tile(table[:1], (memories(), 1))
    for _ in range(CYCLES):
        angles, _, last = play(memory, closed, durations, theta)
        if np.abs(last - memory).max() <= FADED:
            return np.roll(angles, 1, axis=0)
        memory = last
    raise InputError("[[effects]] the servos never settle into a periodic motion: the cycle is too quick for them.")


def play_with_derivatives(theta: Floats, setpoints: Floats, times: Floats) -> tuple[Floats, Floats, Floats]:
    """Angles and readings (R, m) of a trial from rest, and the derivatives of both by theta (R, m, P, 2)."""
    late = late_by(theta)
    if late:
        told, mesh, at = asked_earlier(setpoints, times, late)
        angles, readings, slopes = _with_derivatives(theta, told, mesh)
        return angles[at], readings[at], slopes[at]
    return _with_derivatives(theta, setpoints, times)


def _with_derivatives(theta: Floats, setpoints: Floats, times: Floats) -> tuple[Floats, Floats, Floats]:
    joints = setpoints.shape[1]
    resting, durations = np.concatenate([setpoints[:1], setpoints]), np.concatenate([[1.0], np.diff(times)])
    state = np.vstack([np.tile(setpoints[:1], (memories(), 1)), np.zeros((memories() * len(theta), joints))])
    parts: list[list[Floats]] = [[], [], []]
    for first in range(0, len(durations), CHUNK):
        part = slice(first, min(first + CHUNK, len(durations)))
        count = part.stop - part.start
        inputs = _inputs(resting, durations, part, theta)
        result = _rollout(joints, count)(state, *inputs)
        state = result[0].full()[:, -joints:]
        shapes = (count, joints), (count, joints), (count, joints, 2, len(theta))
        for found, value, shape in zip(parts, result[1:], shapes, strict=True):
            found.append(value.full().T.reshape(shape))
    angles, readings, slopes = (np.concatenate(found) for found in parts)
    return angles, readings, np.swapaxes(slopes, 2, 3)


def coordinates(model: Model, candidates: Sequence[ActiveEffect] = ()) -> Floats:
    """theta (P, m): an effect's coordinates at its joint (or at all), its resting ones elsewhere."""
    return coordinates_of((*model.actuation_effects, *candidates), model.body.joint_count)


def coordinates_of(effects: Sequence[ActiveEffect], joints: int) -> Floats:
    """theta (P, m) of actuation effects on so many joints."""
    blocks = []
    for kind in actuation_effects():
        block = np.repeat(np.array([*(p.resting for p in kind.parameters), 0.0])[:, None], joints, axis=1)
        for active in (e for e in effects if e.name == kind.name):
            where = slice(None) if active.place is None else slice(active.place - 1, active.place)
            block[:, where] = np.array(active.coordinates)[:, None]
        blocks.append(block)
    return np.vstack(blocks)


def played_from_rest(theta: Floats, setpoints: Floats, durations: Floats) -> Floats:
    """True angles (R, C) [rad] of columns of joints with coordinates theta (P, C), after each of the steps of
    `durations` (R - 1,) [s] between set-points (R, C)."""
    memory = np.tile(setpoints[:1], (memories(), 1))
    return np.concatenate([setpoints[:1], play(memory, setpoints, durations, theta)[0]])


def _inputs(setpoints: Floats, durations: Floats, part: slice, theta: Floats) -> tuple[Floats, ...]:
    """Set-points before and after, durations and theta, one column per step and joint."""
    before, after = setpoints[:-1][part].reshape(1, -1), setpoints[1:][part].reshape(1, -1)
    repeated = np.repeat(durations[part], setpoints.shape[1])[None]
    return before, after, repeated, np.tile(theta, (1, part.stop - part.start))


@lru_cache(maxsize=64)
def _rollout(joints: int, count: int) -> ca.Function:
    return joint_sensitivity().map(joints).mapaccum(count)
