"""One trial as the diagnosis needs it: what was commanded, what servos read, what cameras saw; SI, from t0 on.

Shapes come from the servos (shape_in_time.py). Without a servo log they are what the markers show, and so are the
readings: `by_servos` is False.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Body, Floats
from serpenoid.diagnose.data.recordings.clocks import Clock
from serpenoid.diagnose.data.recordings.told import Told
from serpenoid.diagnose.data.shapes.course import Course
from serpenoid.diagnose.data.shapes.geometry import LEAST_MARKERS, register, shapes
from serpenoid.diagnose.data.shapes.shape_in_time import PER_KNOT, ShapeInTime, Source, fitted, spacing
from serpenoid.errors import InputError
from serpenoid.measure.clock import ROBUST
from serpenoid.measure.logs import TICK
from serpenoid.measure.remark import Remark
from serpenoid.measure.schedule import Schedule
from serpenoid.measure.shapes.links import marker_angles

READING_SD = TICK / 2  # rad
WINDOWS_PER_CYCLE = 8
UNSURE_CYCLE = 0.25  # of a cycle: slow servos look like a late start, and what follows a wave is no later than this
ACTED_ON_S = 2e-3  # from the log of a command to the servo that acts on it
SAID_CYCLE = 0.1  # of a cycle: a log whose readings are further apart does not say when a motion began


@dataclass(frozen=True)
class Recording:
    """time (F,) [s since t0 on the cameras' clock], markers (F, N, 2) [m], NaN hidden; the log on its own clock.

    log_time (R,): servo clock, seconds since t0, not corrected for its rate (`clock.rate`); position (R, m) [rad], NaN
    where it is not read. t0_spread: how far t0 may be off [s]. by_servos: whether positions are the servos' own, not
    what the markers show on every frame.
    remarks: of the campaign's check against itself.
    carrier: what the servos are expected to do, once that is known; commands (R, m) [rad]: what they were told
    as each reading was taken, where the log says it; told: what these say of the trial, None: nothing.
    schedule: no more cycles than the recording may show, as they ran on the film's clock; missing_cycles: how many more
    the campaign promises, but for unplayed_cycles, of which the log says that they were not begun; asked_cycle_s: what
    the campaign promises of a cycle's duration, where that is another.
    strays: vertices whose markers were off in a single frame, and by how much [m]: they count as hidden.
    goals: whether commands that jump are taken as goals, each run to until the next is given.
    camera (2, 2): what unit vectors look like to a camera that is known to be stretched; shapes that markers help to
    tell are of the body as it is.
    put_unseen: whether gaps of all markers in pauses may hide that it was put elsewhere (put_elsewhere.py).
    shown (F, m): bends that markers show [rad] of joints whose readings they refute, NaN elsewhere; None: of no joint.
    """

    name: str
    gait: str
    body: Body
    schedule: Schedule
    time: Floats
    markers: Floats
    log_time: Floats
    position: Floats
    clock: Clock
    t0_spread: float
    by_servos: bool = True
    remarks: tuple[Remark, ...] = ()
    carrier: Course | None = None
    commands: Floats | None = None
    missing_cycles: int = 0
    unplayed_cycles: int = 0
    told: Told | None = None
    asked_cycle_s: float | None = None
    strays: tuple[tuple[int, float], ...] = ()
    goals: bool = False
    camera: Floats | None = None
    shown: Floats | None = None
    put_unseen: bool = False

    @property
    def held_as_told(self) -> bool | None:
        """Whether commands hold the table's rows; None where they do not say."""
        return None if self.told is None else self.told.held

    @property
    def may_be_goals(self) -> bool:
        """Whether its commands may be goals, for all that a log says."""
        return self.told is not None and self.told.goals

    @property
    def length_unit(self) -> str:
        """A robot's links are known in metres."""
        return "m"

    @property
    def frame_s(self) -> float:
        """Median time between frames."""
        return float(np.median(np.diff(self.time)))

    @property
    def setting(self) -> tuple[str, float]:
        """Trials with the same one are repeats, whatever a cycle lasts on their film's clock."""
        return self.gait, self.asked_cycle_s or self.schedule.cycle_duration_s

    @property
    def promised_s(self) -> float:
        """Seconds that the campaign promises."""
        return (self.schedule.cycles + self.missing_cycles) * self.schedule.period_s

    @property
    def start_said(self) -> bool:
        """Whether labels of a log say when the motion began."""
        return self.t0_spread < SAID_CYCLE * self.schedule.cycle_duration_s

    @property
    def unsure_start(self) -> float:
        """How far t0 may be off [s]."""
        return self.t0_spread + ACTED_ON_S

    @cached_property
    def begins_known(self) -> bool:
        """Whether what is left open of its beginning is little beside what is commanded meanwhile: a log says it, and
        the command runs, by slopes that change by little. Where rows jump, a slow log says of a jump only that it was
        between two readings; where slopes change much, a start that is moved to first order misses the corners, by

            RMS = d D sqrt(d / 3 h)        d: how far t0 may be off, D: RMS change of slope, h: from row to row
        """
        s, off = self.schedule, self.unsure_start
        if not self.start_said or s.held:
            return False
        slopes = np.diff(s.table, axis=0, append=s.table[:1]) / s.row_s
        change = np.sqrt((np.diff(slopes, axis=0, append=slopes[:1]) ** 2).mean(axis=0)).max()
        return bool(off * change * np.sqrt(min(off / (3 * s.row_s), 1.0)) < TICK / np.sqrt(12))

    @property
    def lag_untold(self) -> bool:
        """Whether a log has no commands or labels that would tell held rows from a lag of servos."""
        return self.by_servos and self.held_as_told is None and not self.start_said

    @property
    def read_at(self) -> Floats:
        """Times (R,) [s since t0 on the cameras' clock] of the readings."""
        return self.log_time / (1 + self.clock.rate)

    def later(self, late_s: float) -> Recording:
        """The same with t0 so much later on the film's clock [s]."""
        return replace(self, time=self.time - late_s, log_time=self.log_time - late_s * (1 + self.clock.rate))

    def due_later(self, goals: bool) -> float:
        """By how much [s] rows are due later where commands that jump are goals (or are none): a goal is given when
        the row before it is due."""
        return self.schedule.row_s * ((goals and self.may_be_goals) - self.goals)

    def taken(self, held: bool, goals: bool) -> Recording:
        """With rows that are held or run; goals: commands that jump are these, and t0 is when the first is reached."""
        schedule, late = replace(self.schedule, held=held), self.due_later(goals)
        return replace(self.later(late), schedule=schedule, goals=goals and self.may_be_goals)

    @property
    def end(self) -> float:
        """Last moment that both schedule and cameras cover [s]."""
        return float(min(self.promised_s, self.time[-1]))

    def stretch(self, time: Floats) -> np.ndarray:
        """Label of the stretch each time lies in: -1 before t0, 2 n while cycle n is played, 2 n + 1 in its pause."""
        cycle = np.clip(np.floor(time / self.schedule.period_s), 0, self.schedule.cycles - 1)
        pause = time - cycle * self.schedule.period_s >= self.schedule.cycle_duration_s
        return np.where(time < 0, -1, 2 * cycle + pause).astype(int)

    @cached_property
    def reading_s(self) -> float:
        """Median time between readings."""
        return float(np.median(np.diff(self.read_at)))

    @property
    def slow(self) -> bool:
        """Whether readings are too far apart to tell shapes alone."""
        return self.by_servos and spacing(self.schedule.cycle_duration_s) < PER_KNOT * self.reading_s

    @cached_property
    def shape(self) -> ShapeInTime:
        """Joint angles in time, as servos read them; with what the markers show where the log is slow.

        Of what comes after the promised end nothing is known: a servo that is late goes on to its goal, or is let go.
        """
        schedule, log_s = self.schedule, self.read_at
        begun = schedule.period_s * np.arange(schedule.cycles + 1)
        corners = np.unique(np.concatenate([begun, begun[:-1] + schedule.cycle_duration_s]))
        apart = spacing(schedule.cycle_duration_s)
        sd, tick = np.full(self.body.joint_count, READING_SD), TICK if self.by_servos else 0.0
        sources = [Source.of(log_s, self._believed, sd, tick)]
        sources += [] if self.shown is None else [Source.of(self.time, self.shown, sd)]
        sources = [s.until(self.promised_s) for s in sources]
        if self.slow:
            read = fitted(sources, corners, max(apart, self.reading_s), carrier=self.carrier)
            shown = self._shown(read)
            if not shown:
                return read
            sources += [s.until(self.promised_s) for s in shown]
        return fitted(sources, corners, apart, self.carrier is not None or not self.by_servos, self.carrier)

    @property
    def by_markers(self) -> NDArray[np.bool_]:
        """At which joints (m,) bends are what markers show."""
        if self.shown is None:
            return np.full(self.body.joint_count, not self.by_servos)
        return np.asarray(np.isfinite(self.shown).any(axis=0))

    @property
    def _believed(self) -> Floats:
        """Readings (R, m), NaN of joints at which markers are believed."""
        return self.position if self.shown is None else np.where(self.by_markers, np.nan, self.position)

    def _shown(self, read: ShapeInTime) -> list[Source]:
        """Marker angles on the frames, the joints' own zeros taken out, where they are known often enough."""
        markers = self.markers if self.camera is None else self.markers @ np.linalg.inv(self.camera)
        shown = marker_angles(self.body, markers)
        miss = shown - read.at(self.time)
        if not np.isfinite(miss).sum(axis=0).all():
            return []
        zero = np.nanmedian(miss, axis=0)
        sd = ROBUST * np.nanmedian(np.abs(miss - zero), axis=0)
        return [Source.of(self.time, shown - zero, np.maximum(sd, READING_SD))]

    def with_middles(self, pieces: int = 1) -> Recording:
        """The same of the body with vertices in the middles of its edges, which have no markers: see `Body`."""
        body = self.body.with_middles(pieces)
        markers = np.full((len(self.markers), body.vertices, 2), np.nan)
        markers[:, :: pieces + 1] = self.markers
        return replace(self, body=body, markers=markers)

    @cached_property
    def angles(self) -> Floats:
        """Servo readings (F, m) on the camera frames, smoothed."""
        return self.shape.at(self.time)

    @cached_property
    def marker_noise(self) -> float:
        """SD of a marker's coordinate [m], from how neighbouring frames differ.

        A rigid fit takes three numbers of the 2 K that K markers bring: what it leaves is scaled by 2 K / (2 K - 3).
        """
        seen = np.isfinite(self.markers[..., 0]).sum(axis=1)
        if not (seen >= LEAST_MARKERS).any():
            raise InputError(
                f"trial `{self.name}`: never are {LEAST_MARKERS} markers seen at once: no pose can be known."
            )
        left = register(shapes(self.body, self.angles), self.markers)[1]
        count = 2 * np.median(seen[seen >= LEAST_MARKERS])
        between = float(np.nanmedian(np.abs(np.diff(left, axis=0))))
        return float(ROBUST * between / np.sqrt(2) * np.sqrt(count / (count - 3)))

    def angles_at(self, time: Floats) -> Floats:
        """Smoothed joint angles (R, m) at other times."""
        return self.shape.at(time)


HELD_OUT: dict[str, Callable[[Recording], object]] = {"gaits": lambda r: r.gait, "settings": lambda r: r.setting}


def held_out_by(recordings: Sequence[Recording]) -> str:
    """What is held out together: trials of one gait; with a single gait, of one setting; else each trial by itself."""
    return next((kind for kind, of in HELD_OUT.items() if len({of(r) for r in recordings}) > 1), "trials")


def held_as_all_told(recordings: Iterable[Recording]) -> set[bool]:
    """Whether commands hold rows, as clear ones of some trials say; empty where none do."""
    return {r.held_as_told for r in recordings if r.held_as_told is not None}


def held_out_labels(recordings: Sequence[Recording]) -> tuple[int, ...]:
    """A number for all that is held out together."""
    of = HELD_OUT.get(held_out_by(recordings))
    names = list(range(len(recordings))) if of is None else [of(r) for r in recordings]
    numbers = {name: i for i, name in enumerate(dict.fromkeys(names))}
    return tuple(numbers[name] for name in names)
