"""What was commanded beside what the servos read of it, and what they are expected to do.

The set-point runs linearly from row to row, or jumps to each when it is due, or is what the log itself says that the
servos were told: whichever the readings follow best, as they are or with one law for all servos. A log says when a
trial began to a part of its interval only, and its rate beside the cameras' clock is known as well as noisy markers
show it: every trial has a shift and a rate of its own within these bounds.

Legend: R log rows of all trials, m joints.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import NORMAL, structure
from serpenoid.diagnose.data.noise import TICK
from serpenoid.diagnose.data.recording import Recording
from serpenoid.diagnose.data.shape_in_time import Course, spacing
from serpenoid.diagnose.inference.law_error import LAW_ERROR
from serpenoid.diagnose.stages.marker_evidence import AVERAGED_S
from serpenoid.effects.active import ActiveEffect, joined
from serpenoid.measure.schedule import Schedule
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.simulation.servos import realise_all

SMOOTHED_ROWS = 9
ACTED_ON_S = 2e-3  # from the log of a command to the servo that acts on it
JUMP_S = 1e-6  # before a row is due: a jump takes no time
KNOTS = 3.5  # each way: the stretch in which readings are compared with a parabola
MEETINGS = 9  # steps in which it is found when a trial began: each far smaller than the last
WITHIN_ROW = 4  # steps in which servos are followed from row to row


@dataclass(frozen=True)
class Plays:
    """The servos' readings (R, m) [rad], trial numbers (R,), and set-points on meshes that meet every row.

    noise (m,) [rad]: of a reading. known: effects that are no news; habit (R, m) [rad]: what readings are known to
    differ by from what these make of the set-points. unsure (m,) [rad]: how much of that a change of something else may
    change; it is no noise, but what is smaller says nothing of the servos. without: effects that are no candidates.
    told: whether the set-points are the log's own.
    """

    recordings: tuple[Recording, ...]
    readings: Floats
    trials: np.ndarray
    times: tuple[Floats, ...]
    meshes: tuple[Floats, ...]
    setpoints: tuple[Floats, ...]
    where: tuple[np.ndarray, ...]
    noise: Floats
    known: tuple[ActiveEffect, ...] = ()
    habit: Floats | float = 0.0
    unsure: Floats | float = 0.0
    without: frozenset[str] = frozenset()
    told: bool = False

    @property
    def held(self) -> bool:
        """Whether the rows of the tables jump."""
        return self.recordings[0].schedule.held

    @property
    def quickest(self) -> Floats:
        """Largest speed (m,) [rad/s] of each joint from one row of a table to the next."""
        steps = [np.abs(np.diff(s.table, axis=0, append=s.table[:1])).max(axis=0) for s in self._schedules]
        rows = [len(s.table) / s.cycle_duration_s for s in self._schedules]
        return np.max([step * often for step, often in zip(steps, rows, strict=True)], axis=0)

    @property
    def _schedules(self) -> list[Schedule]:
        return [r.schedule for r in self.recordings]

    def left(self, played: Floats) -> Floats:
        """Readings minus what is played (R, m), each trial's clock moved as far as that is worth it."""
        found, speed = self.readings - played, self.speed(played)
        moves = self._moves(found, speed)
        for mine, time, (shift, rate) in zip(self._rows, self.times, moves, strict=True):
            found[mine] -= (shift + rate * time)[:, None] * speed[mine]
        return found

    @cached_property
    def _rows(self) -> list[slice]:
        """Of each trial, one after the other."""
        ends = np.cumsum([len(t) for t in self.times])
        return [slice(end - len(t), end) for end, t in zip(ends, self.times, strict=True)]

    def chi2(self, played: Floats) -> Floats:
        """Of each joint (m,)."""
        return self.sizes(self.left(played))

    def sizes(self, left: Floats) -> Floats:
        """Chi squared (m,) of what is left (R, m)."""
        return np.asarray((left**2).sum(axis=0) / self.noise**2)

    def _moves(self, found: Floats, speed: Floats) -> list[tuple[float, float]]:
        """Of each trial, shift [s] and rate: the best that what is known of its clock allows."""
        moves = []
        for mine, r, time in zip(self._rows, self.recordings, self.times, strict=True):
            v, miss = (x[mine] / self.noise for x in (speed, found))
            power, pull = (v**2).sum(axis=1), (v * miss).sum(axis=1)
            once, late, later = (max(float((power * time**n).sum()), 1e-12) for n in range(3))
            now, then = float(pull.sum()), float((pull * time).sum())
            most = NORMAL * float(np.hypot(r.clock.rate, r.clock.rate_sd))  # whose clock commands follow is not known
            apart = max(once * later - late**2, 1e-9 * once * later)
            rate = float(np.clip((then * once - now * late) / apart, -most, most))
            near = unsure_start(r) + abs(rate) * float(time[-1])  # labels bound both together
            moves.append((float(np.clip((now - rate * late) / once, -near, near)), rate))
        return moves

    def speed(self, played: Floats) -> Floats:
        """Rates (R, m) [rad/s] of what is played."""
        parts = zip(self._rows, self.times, strict=True)
        return np.concatenate([np.gradient(played[mine], time, axis=0) for mine, time in parts])

    def slope(self, played: Floats, moved: Floats, step: float) -> Floats:
        """By which `left` (R, m) falls with a parameter whose `step` moves what is played."""
        return np.asarray((self.left(played) - self.left(moved)) / step)

    def realised(self, effects: Sequence[ActiveEffect]) -> Floats:
        """What the servos would read (R, m) with these effects, in place of or after the known ones."""
        played = realise_all(self.model(effects), self.setpoints, self.meshes)
        sampled = (self._sampled(number, p.readings) for number, p in enumerate(played))
        return np.concatenate(list(sampled)) + self.habit

    def _sampled(self, number: int, angles: Floats) -> Floats:
        """What a trial's mesh plays (K, m) when it is read; from where readings are met best if nothing says when it
        began."""
        recording, time = self.recordings[number], self.times[number]
        if recording.start_said:
            return angles[self.where[number]]
        course = Course(self.meshes[number], angles)
        late = _late(course, time, self.readings[self._rows[number]], unsure_start(recording))
        return course.at(time - late)

    def realised_at(self, joint: int, effects: Sequence[ActiveEffect], others: Floats) -> Floats:
        """The same where one joint (1 = next to the tail) alone reads anything else than `others` (R, m)."""
        if not all(r.start_said for r in self.recordings):  # when a trial began depends on all joints
            return self.realised(effects)
        found, columns = others.copy(), slice(joint - 1, joint)
        played = realise_all(self.model(effects), self.setpoints, self.meshes, columns)
        parts = [p.readings[where] for p, where in zip(played, self.where, strict=True)]
        habit = np.broadcast_to(self.habit, found.shape)
        found[:, columns] = np.concatenate(parts) + habit[:, columns]
        return found

    def model(self, effects: Sequence[ActiveEffect]) -> Model:
        """The robot with the known effects and these."""
        return Model(self.recordings[0].body, Medium(anisotropy_ratio=0.2), joined(self.known, effects))

    def channels(self, played: Floats) -> Floats:
        """RMS of what is left in units of noise, of each joint (m,)."""
        return np.asarray(np.sqrt((self.left(played) ** 2).mean(axis=0)) / self.noise)

    def structure(self, played: Floats) -> Floats:
        """Mean square (m,) of what is left, over what it is held against; 0 where chance alone makes as much."""
        found = structure(self.left(played) / self.noise, self.trials[1:] == self.trials[:-1])
        return found * (self.noise / self.held_against) ** 2

    @property
    def held_against(self) -> Floats:
        """What of a reading (m,) [rad] says nothing of its servo: noise, and what a change of something else may do."""
        return np.asarray(np.hypot(self.noise, self.unsure))

    @property
    def level(self) -> Floats:
        """The same that effects are held against: noise of markers' angles averaged over time, as poses are."""
        if self.recordings[0].by_servos:
            return self.held_against
        apart = float(np.median(np.concatenate([np.diff(t) for t in self.times])))
        return np.asarray(np.hypot(self.noise / np.sqrt(max(AVERAGED_S / apart, 1.0)), self.unsure))

    def alone(self, played: Floats) -> Floats:
        """What is played (R, m), every joint's clock moved as far as is worth it to that joint: what most joints follow
        is not hidden by one that does not."""
        found, speed, moved = self.readings - played, self.speed(played), played.copy()
        for r, mine in zip(self.recordings, self._rows, strict=True):
            pull, power = (found[mine] * speed[mine]).sum(axis=0), (speed[mine] ** 2).sum(axis=0)
            moved[mine] += np.clip(pull / np.maximum(power, 1e-12), -unsure_start(r), unsure_start(r)) * speed[mine]
        return moved

    def missed(self, played: Floats) -> Floats:
        """Mean square (m,) of what is left beyond noise, in units of the level's."""
        return np.asarray((self.channels(played) ** 2 - 1) * (self.noise / self.level) ** 2)

    def measured(self, played: Floats) -> Plays:
        """The same with the noise that readings have about what is played, if it is less."""
        left = self.readings - played
        found = [_scatter(left[self.trials == n], r.by_servos) for n, r in enumerate(self.recordings)]
        least = TICK / np.sqrt(12) if self.recordings[0].by_servos else 0.0
        return replace(self, noise=np.minimum(self.noise, np.maximum(np.percentile(found, 25, axis=0), least)))


def unsure_start(r: Recording) -> float:
    """How far t0 may be off [s]."""
    return r.t0_spread + ACTED_ON_S


def _late(course: Course, time: Floats, readings: Floats, near: float) -> float:
    """By how much later [s], no more than `near`, a course is read best (R, m) at time (R,)."""
    rates = np.diff(course.angles, axis=0) / np.diff(course.time)[:, None]
    late = 0.0
    for _ in range(MEETINGS):
        at = time - late
        rate = rates[np.clip(np.searchsorted(course.time, at) - 1, 0, len(rates) - 1)]
        change = float(((readings - course.at(at)) * rate).sum() / max(float((rate**2).sum()), 1e-12))
        late, before = float(np.clip(late - change, -near, near)), late
        if abs(late - before) < JUMP_S:
            break
    return late


def ways(recordings: Sequence[Recording]) -> Iterator[Plays]:
    """Readings between t0 and the end, at the log's own times, beside the set-points in every way to take them."""
    recordings = _telling(recordings)
    yield _plays(recordings, told=False)
    jumping = [replace(r, schedule=replace(r.schedule, held=True)) for r in recordings]
    yield _plays(jumping, told=False)
    if all(r.commands is not None for r in recordings):
        yield _plays(jumping, told=True)


def _telling(recordings: Sequence[Recording]) -> list[Recording]:
    """One of each setting, and its repeats in which a joint strays from the command by another amount."""
    found: list[tuple[Recording, Floats, Floats]] = []
    for r in reversed(recordings):
        strays, unsure = _strays(r)
        like = [(s, u) for other, s, u in found if other.setting == r.setting]
        differs = (np.abs(s - strays) > LAW_ERROR**2 * np.maximum(s, strays) + np.maximum(u, unsure) for s, u in like)
        if all(d.any() for d in differs):
            found.append((r, strays, unsure))
    return [r for r, _, _ in reversed(found)]


def _strays(r: Recording) -> tuple[Floats, Floats]:
    """Mean square (m,) of what a trial's readings miss the command by, and how much of it may be its start's."""
    time = r.read_at
    inside = (time > 0) & (time < r.promised_s)
    if not inside.any():
        return np.zeros(r.body.joint_count), np.full(r.body.joint_count, np.inf)
    told = r.schedule.commanded(time[inside])
    late = r.schedule.commanded(time[inside] - unsure_start(r)) - told
    return ((r.position[inside] - told) ** 2).mean(axis=0), (late**2).mean(axis=0) + TICK**2


def _plays(recordings: Sequence[Recording], told: bool) -> Plays:
    readings, labels, times, meshes, setpoints, where = [], [], [], [], [], []
    for number, r in enumerate(recordings):
        time = r.read_at
        inside = (time > 0) & (time < r.schedule.cycles * r.schedule.period_s)
        mesh = np.unique(np.concatenate([[0.0], time[inside], [] if told else _corners(r)]))
        course = Course(time, r.commands) if told and r.commands is not None else None
        setpoints.append(r.schedule.commanded(mesh) if course is None else course.at(mesh))
        times.append(time[inside])
        meshes.append(mesh)
        where.append(np.searchsorted(mesh, time[inside]))
        readings.append(r.position[inside])
        labels.append(np.full(len(readings[-1]), number))
    noise = np.full(recordings[0].body.joint_count, np.inf)
    found = Plays(
        tuple(recordings), np.concatenate(readings), np.concatenate(labels), tuple(times), tuple(meshes),
        tuple(setpoints), tuple(where), noise, told=told,
    )  # fmt: skip
    return found.measured(np.zeros_like(found.readings)).measured(found.realised([]))


def _corners(r: Recording) -> Floats:
    """Times from 0 on at which rows are due, and just before where they jump."""
    s, steps = r.schedule, len(r.schedule.table)
    corners = [n * s.period_s + np.arange(steps + 1) / steps * s.cycle_duration_s for n in range(s.cycles)]
    jumps = [c - JUMP_S for c in corners] if s.held else []
    every = np.concatenate([*corners, *jumps])
    return np.asarray(every[every >= 0])


def _between(r: Recording) -> Floats:
    """Times from 0 on, some in each row, at which servos are followed, in pauses and to the log's end as well."""
    apart = r.schedule.cycle_duration_s / len(r.schedule.table) / WITHIN_ROW
    return np.asarray(apart * np.arange(max(r.read_at[-1], r.end) / apart + 1))


def carried(recordings: Sequence[Recording], found: Plays, effects: Sequence[ActiveEffect]) -> tuple[Recording, ...]:
    """Recordings with what their servos are expected to do, joint by joint where readings are smoother about it."""
    recordings = [replace(r, schedule=replace(r.schedule, held=found.held)) for r in recordings]
    pairs = zip(recordings, expected(recordings, found, effects), strict=True)
    return tuple(_carried(r, course) for r, course in pairs)


def expected(recordings: Sequence[Recording], found: Plays, effects: Sequence[ActiveEffect]) -> tuple[Course, ...]:
    """What servos are expected to do, trial by trial, with these effects beside the known ones."""
    recordings = [replace(r, schedule=replace(r.schedule, held=found.held)) for r in recordings]
    meshes = [np.unique(np.concatenate([_corners(r), _between(r) if effects else [0.0]])) for r in recordings]
    told = [r.schedule.commanded(t) for r, t in zip(recordings, meshes, strict=True)]
    played = realise_all(found.model(effects), told, meshes)
    courses = [Course(time, p.readings) for time, p in zip(meshes, played, strict=True)]
    return tuple(c if r.start_said else _begun(r, c) for r, c in zip(recordings, courses, strict=True))


def _begun(r: Recording, course: Course) -> Course:
    """A course from where a trial's readings meet it best."""
    inside = (r.read_at > 0) & (r.read_at < r.end)
    late = _late(course, r.read_at[inside], r.position[inside], unsure_start(r))
    return Course(course.time + late, course.angles)


def _carried(r: Recording, course: Course) -> Recording:
    rows = 2 * int(KNOTS * spacing(r.schedule.cycle_duration_s) / np.median(np.diff(r.read_at))) + 1
    rows = max(rows, SMOOTHED_ROWS)
    if len(r.position) < rows:
        return r
    bare, about = (roughness(values, rows) for values in (r.position, r.position - course.at(r.read_at)))
    return replace(r, carrier=replace(course, angles=np.where(about < bare, course.angles, 0.0)))


def _scatter(readings: Floats, pooled: bool) -> Floats:
    """RMS about local parabolas [rad], corrected for what they swallow: of each joint (m,), or pooled: the median's."""
    if len(readings) < SMOOTHED_ROWS:
        return np.full(readings.shape[1], TICK)
    squares = roughness(readings, SMOOTHED_ROWS) ** 2 / (1 - 2.25 / SMOOTHED_ROWS)
    return np.asarray(np.sqrt(np.full_like(squares, np.median(squares)) if pooled else squares))


def roughness(values: Floats, rows: int) -> Floats:
    """RMS of `values` (R, m) about local parabolas (m,)."""
    return np.asarray(np.sqrt(((values - local_parabolas(values, rows)) ** 2).mean(axis=0)))


def local_parabolas(values: Floats, rows: int) -> Floats:
    """Each of `values` (R, m) by the parabola through the `rows` about it (Savitzky and Golay, 1964), R >= rows.

    SciPy's, without its package for signals, whose import takes as long as all others together.
    """
    powers, middle = np.vander(np.arange(rows) - rows // 2, 3), rows // 2
    smoother = powers @ np.linalg.pinv(powers)
    inside = np.lib.stride_tricks.sliding_window_view(values, rows, axis=0) @ smoother[middle]
    return np.concatenate([smoother[:middle] @ values[:rows], inside, smoother[middle + 1 :] @ values[-rows:]])
