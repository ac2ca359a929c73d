"""What was commanded beside what the servos read of it.

The set-point runs linearly from row to row, or jumps to each when it is due, or is what the log itself says that the
servos were told (`set_points`): whichever the readings follow best, as they are or with one law for all servos. A log
says when a trial began to a part of its interval only, and its rate beside the cameras' clock is known as well as noisy
markers show it: every trial has a shift and a rate of its own within these bounds.

Legend: R log rows of all trials, m joints.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import NORMAL, structure
from serpenoid.diagnose.data.recordings.recording import ACTED_ON_S, UNSURE_CYCLE, Recording
from serpenoid.diagnose.data.shapes.course import Course, Readings
from serpenoid.diagnose.data.shapes.smooth import AVERAGED_S, scatter
from serpenoid.effects.active import ActiveEffect, joined
from serpenoid.measure.clock import bridged
from serpenoid.measure.logs import TICK
from serpenoid.measure.schedule import Schedule
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.simulation.servos import readings_of_each

SIDE_BY_SIDE = 4  # sets of effects: what they play is kept until it is sampled


@dataclass(frozen=True)
class Plays:
    """The servos' readings (R, m) [rad], trial numbers (R,), and set-points on meshes that meet every row.

    A reading that is not there is NaN, and counts nowhere. noise (m,) [rad]: of a reading. known: effects that are no
    news; habit (R, m) [rad]: what readings are known to differ by from what these make of the set-points. unsure (m,)
    [rad]: how much of that a change of something else may change; it is no noise, but what is smaller says nothing of
    the servos. without: effects that are no candidates. told: whether the set-points are the log's own.
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
    def goals(self) -> bool:
        """Whether commands that jump are taken as goals."""
        return any(r.goals for r in self.recordings)

    def unsure_start(self, r: Recording) -> float:
        """How far what a trial was told may be off in time [s]: the log's own commands have the readings' clock."""
        return ACTED_ON_S if self.told else r.unsure_start

    def said(self, r: Recording) -> bool:
        """Whether a log says, to a part of its interval, when what a trial was told began."""
        return self.told or r.start_said

    def begun(self, r: Recording) -> bool:
        """Whether it is known when that was: else what is played is moved to where readings meet it best."""
        return self.told or r.begins_known

    @property
    def quickest(self) -> Floats:
        """Largest speed (m,) [rad/s] of each joint from one row of a table to the next."""
        steps = [np.abs(np.diff(s.table, axis=0, append=s.table[:1])).max(axis=0) for s in self._schedules]
        rows = [len(s.table) / s.cycle_duration_s for s in self._schedules]
        return np.max([step * often for step, often in zip(steps, rows, strict=True)], axis=0)

    @cached_property
    def _came_from(self) -> list[Floats]:
        """What servos read before each trial (m,)."""
        return [came_from(r, s) for r, s in zip(self.recordings, self.setpoints, strict=True)]

    @property
    def _schedules(self) -> list[Schedule]:
        return [r.schedule for r in self.recordings]

    def left(self, played: Floats, by: NDArray[np.bool_] | bool = True) -> Floats:
        """Readings minus what is played (R, m), each trial's clock moved as far as that is worth it; 0 unread.

        by (m,): the joints whose readings move it.
        """
        found, speed = self._missed(played), self.speed(played)
        moves = self._moves(found, speed * by)
        for mine, time, (shift, rate) in zip(self._rows, self.times, moves, strict=True):
            found[mine] -= (shift + rate * time)[:, None] * speed[mine]
        return found

    @cached_property
    def read(self) -> NDArray[np.bool_]:
        """What is read (R, m)."""
        return np.isfinite(self.readings)

    @cached_property
    def often(self) -> Floats:
        """How many readings each joint has (m,), one at least."""
        return np.maximum(self.read.sum(axis=0), 1.0)

    def _missed(self, played: Floats) -> Floats:
        """Readings minus what is played (R, m), 0 unread."""
        return np.where(self.read, self.readings - played, 0.0)

    @cached_property
    def _rows(self) -> list[slice]:
        """Of each trial, one after the other."""
        ends = np.cumsum([len(t) for t in self.times])
        return [slice(end - len(t), end) for end, t in zip(ends, self.times, strict=True)]

    def chi2(self, played: Floats, by: NDArray[np.bool_] | bool = True) -> Floats:
        """Of each joint (m,); by: see `left`."""
        return self.sizes(self.left(played, by))

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
            # whose clock commands follow is not known, but where the log has them
            most = 0.0 if self.told else NORMAL * float(np.hypot(r.clock.rate, r.clock.rate_sd))
            apart = max(once * later - late**2, 1e-9 * once * later)
            rate = float(np.clip((then * once - now * late) / apart, -most, most))
            near = self.unsure_start(r) + abs(rate) * float(time[-1])  # labels bound both together
            moves.append((float(np.clip((now - rate * late) / once, -near, near)), rate))
        return moves

    def speed(self, played: Floats) -> Floats:
        """Rates (R, m) [rad/s] of what is played; 0 unread."""
        parts = zip(self._rows, self.times, strict=True)
        rates = np.concatenate([np.gradient(played[mine], time, axis=0) for mine, time in parts])
        return np.where(self.read, rates, 0.0)

    def slope(self, left: Floats, moved: Floats, step: float) -> Floats:
        """By which what is `left` (R, m) falls with a parameter whose `step` moves what is played (R, m)."""
        return np.asarray((left - self.left(moved)) / step)

    def realised(self, effects: Sequence[ActiveEffect]) -> Floats:
        """What the servos would read (R, m) with these effects, in place of or after the known ones."""
        return self.met(effects)[0]

    def realised_each(self, several: Sequence[Sequence[ActiveEffect]]) -> list[Floats]:
        """The same with each of several effects, side by side."""
        return [self._sampled(played, self._begun(played)) for played in self._played_each(several)]

    def strength(self, effect: ActiveEffect) -> float:
        """RMS of what an effect alone changes at the worst joint, over the noise."""
        alone = self.realised([effect]) - self.realised([])
        return float((np.sqrt((alone**2).mean(axis=0)) / self.level).max())

    def met(self, effects: Sequence[ActiveEffect]) -> tuple[Floats, list[float | None]]:
        """The same, and how late each trial begins so [s]: where readings are met best; None where that is known."""
        played = self._played(effects)
        late = self._begun(played)
        return self._sampled(played, late), late

    def begun_at(self, several: Sequence[Sequence[ActiveEffect]], late: Sequence[float | None]) -> list[Floats]:
        """The same with each of several effects where each trial begins so late [s]."""
        return [self._sampled(played, late) for played in self._played_each(several)]

    def _played(self, effects: Sequence[ActiveEffect]) -> list[Floats]:
        """What the servos do (K, m) on each trial's mesh."""
        return next(self._played_each([effects]))

    def _played_each(
        self, several: Sequence[Sequence[ActiveEffect]], some: slice = slice(None)
    ) -> Iterator[list[Floats]]:
        """The same with each of several effects, or some joints of it."""
        for first in range(0, len(several), SIDE_BY_SIDE):
            models = [self.model(effects) for effects in several[first : first + SIDE_BY_SIDE]]
            yield from readings_of_each(models, self.setpoints, self.meshes, self._came_from, some)

    def _begun(self, played: Sequence[Floats]) -> list[float | None]:
        """How late each trial begins that plays so (K, m)."""
        return [self._begun_late(number, p) for number, p in enumerate(played)]

    def _sampled(self, played: Sequence[Floats], late: Sequence[float | None]) -> Floats:
        """What each trial's mesh plays (K, m) when it is read (R, m), so much later [s]; None: as its log says."""
        parts = zip(played, late, self.where, self.meshes, self.times, strict=True)
        read = [p[at] if by is None else Course(mesh, p).at(time - by) for p, by, at, mesh, time in parts]
        return np.concatenate(read) + self.habit

    def _begun_late(self, number: int, angles: Floats) -> float | None:
        """From where on what a trial's mesh plays (K, m) is met best [s], if nothing says when it began."""
        if self.begun(self.recordings[number]):
            return None
        return self._read_late[number].late(Course(self.meshes[number], angles))

    def late(self, effects: Sequence[ActiveEffect]) -> list[float]:
        """By how much later [s] than promised each trial's readings meet best what servos do with these effects."""
        played = zip(self._read_late, self.meshes, self._played(effects), strict=True)
        return [read.late(Course(mesh, angles)) for read, mesh, angles in played]

    @cached_property
    def _read_late(self) -> list[Readings]:
        """Of each trial, as far as its start is open."""
        return self._met_within([self.unsure_start(r) for r in self.recordings])

    def _met_within(self, most: Sequence[float]) -> list[Readings]:
        """Of each trial, met no more than so much [s] earlier or later."""
        parts = zip(self.recordings, self.times, self._rows, most, strict=True)
        return [Readings(time, self.readings[rows], s, r.schedule.jumps_every_s) for r, time, rows, s in parts]

    def each_later(self) -> Floats:
        """What servos read (R, m) that do as they are told, in each trial later by a time of its own: a dead time that
        begins amid the campaign is that, whatever logs say of when trials began. Commands that a log does not have are
        bridged."""
        played = [bridged(mesh, angles) for mesh, angles in zip(self.meshes, self._played(()), strict=True)]
        every = self._met_within([UNSURE_CYCLE * s.cycle_duration_s for s in self._schedules])
        late = [r.late(Course(mesh, angles)) for r, mesh, angles in zip(every, self.meshes, played, strict=True)]
        return self._sampled(played, late)

    def later(self, effects: Sequence[ActiveEffect]) -> Floats:
        """By how much later [s] than logs say each trial began, for readings to meet what servos do with these effects
        best: in its middle."""
        played, late = self.met(effects)
        moves = self._moves(self._missed(played), self.speed(played))
        middle = [shift + rate * float(t.mean()) for t, (shift, rate) in zip(self.times, moves, strict=True)]
        return np.array([begun or 0.0 for begun in late]) - middle

    def at_joint(
        self, joint: int, others: Sequence[ActiveEffect]
    ) -> tuple[Floats, Callable[[Sequence[Sequence[ActiveEffect]]], list[Floats]]]:
        """What is read with some effects, and `realised_each` of those that differ from them at one joint alone (1 =
        next to the tail), where it is known when trials began: else that depends on all joints."""
        read, columns = self.realised(others), slice(joint - 1, joint)
        habit = np.broadcast_to(self.habit, read.shape)[:, columns]

        def realised_each(several: Sequence[Sequence[ActiveEffect]]) -> list[Floats]:
            every = []
            for own in self._played_each(several, columns):
                found = read.copy()
                found[:, columns] = np.concatenate([p[at] for p, at in zip(own, self.where, strict=True)]) + habit
                every.append(found)
            return every

        return read, realised_each

    def model(self, effects: Sequence[ActiveEffect]) -> Model:
        """The robot with the known effects and these."""
        return Model(self.recordings[0].body, Medium(anisotropy_ratio=0.2), joined(self.known, effects))

    def channels(self, played: Floats, by: NDArray[np.bool_] | bool = True) -> Floats:
        """RMS of what is left in units of noise, of each joint (m,); by: see `left`."""
        return np.asarray(np.sqrt(self.chi2(played, by) / self.often))

    def structure(self, played: Floats) -> Floats:
        """Mean square (m,) of what is left, over what it is held against; 0 where chance alone makes as much."""
        return self.structure_of(self.left(played))

    def structure_of(self, left: Floats, rows: NDArray[np.bool_] | slice = slice(None)) -> Floats:
        """The same of what is left (R, m), in some rows."""
        units, trials = np.where(self.read, left / self.noise, np.nan)[rows], self.trials[rows]
        return structure(units, trials[1:] == trials[:-1]) * (self.noise / self.held_against) ** 2

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
        """What is played (R, m), every joint's clock moved as far as is worth it to that joint, and a share of it: what
        most joints follow is not hidden by one that does not, and servos that are weak follow, too."""
        found, speed, moved = self._missed(played), self.speed(played), played.copy()
        for r, mine in zip(self.recordings, self._rows, strict=True):
            pull, power = (found[mine] * speed[mine]).sum(axis=0), (speed[mine] ** 2).sum(axis=0)
            near = self.unsure_start(r)
            moved[mine] += np.clip(pull / np.maximum(power, 1e-12), -near, near) * speed[mine]
        seen = np.where(self.read, moved, 0.0)
        share = (seen * np.where(self.read, self.readings, 0.0)).sum(axis=0) / np.maximum((seen**2).sum(axis=0), 1e-12)
        return np.asarray(share * moved)

    def missed(self, played: Floats, by: NDArray[np.bool_] | bool = True) -> Floats:
        """Mean square (m,) of what is left beyond noise, in units of the level's; by: see `left`."""
        return np.asarray((self.channels(played, by) ** 2 - 1) * (self.noise / self.level) ** 2)

    def measured(self, played: Floats) -> Plays:
        """The same with the noise that readings have about what is played, if it is less."""
        left = self.readings - played
        found = [scatter(left[self.trials == n], r.by_servos) for n, r in enumerate(self.recordings)]
        least = TICK / np.sqrt(12) if self.recordings[0].by_servos else 0.0
        often = [values[np.isfinite(values)] for values in np.transpose(found)]
        quiet = np.array([np.percentile(values, 25) if len(values) else TICK for values in often])
        return replace(self, noise=np.minimum(self.noise, np.maximum(quiet, least)))


def played_for_sure(r: Recording, begun: bool) -> NDArray[np.bool_]:
    """Which readings (R,) are of the promised motion; not `begun` (nothing says when it began): however late that was.
    What servos do after it, nobody has promised."""
    return (r.read_at > 0) & (r.read_at < r.schedule.whole_s - (0.0 if begun else r.unsure_start))


def came_from(r: Recording, told: Floats) -> Floats:
    """What servos read (m,) [rad] at rest before they are told to move (R, m), averaged as poses are; what they are
    told first where nothing was read before. A joint may rest anywhere in its gap."""
    before = r.position[r.read_at < -r.unsure_start]
    last = before[-max(round(AVERAGED_S / float(np.median(np.diff(r.read_at)))), 1) :]
    known = np.isfinite(last)
    mean = np.where(known, last, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    return np.where(known.any(axis=0), mean, told[0])
