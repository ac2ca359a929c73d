"""One trial as the diagnosis needs it: what was commanded, what servos read, what cameras saw; SI, from t0 on.

Shapes come from the servos (shape_in_time.py). Without a servo log they are what the markers show, and so are the
readings: `by_servos` is False.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from serpenoid.body import Body, Floats
from serpenoid.diagnose.data.clocks import Clock, align, start_on_log
from serpenoid.diagnose.data.course import Course
from serpenoid.diagnose.data.geometry import LEAST_MARKERS, register, shapes
from serpenoid.diagnose.data.shape_in_time import PER_KNOT, ShapeInTime, Source, fitted, spacing
from serpenoid.diagnose.data.shapes_from_points import angles_read, angles_shown
from serpenoid.diagnose.data.still import refuse_still
from serpenoid.errors import InputError
from serpenoid.files.store import remember
from serpenoid.measure.campaign import CampaignFile, TrialEntry, load_campaign_file
from serpenoid.measure.consistency.claims import believe
from serpenoid.measure.links import marker_angles
from serpenoid.measure.schedule import Schedule, start_by_shape
from serpenoid.measure.servo_alignment import MIN_CORRELATION
from serpenoid.measure.trial_files import Files, Progress, Reader, content, neighbour_ratio, of_every_trial, read_files

READING_SD = 2 * np.pi / 4096 / 2  # rad: half a tick
WINDOWS_PER_CYCLE = 8
UNSURE_CYCLE = 0.1  # of a cycle: a lag of the servos looks like a late start


@dataclass(frozen=True)
class Recording:
    """time (F,) [s since t0 on the cameras' clock], markers (F, N, 2) [m], NaN hidden; the log on its own clock.

    log_time (R,): servo clock, seconds since t0, not corrected for its rate (`clock.rate`); position (R, m) [rad], NaN
    where it is not read. t0_spread: how far t0 may be off [s]. by_servos: whether positions are the servos' own, not
    what the markers show on every frame.
    remarks: of the campaign's check against itself.
    carrier: what the servos are expected to do, once that is known; commands (R, m) [rad]: what they were told
    as each reading was taken, where the log says it.
    schedule: no more cycles than the recording may show; missing_cycles: how many more the campaign promises.
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
    remarks: tuple[str, ...] = ()
    carrier: Course | None = None
    commands: Floats | None = None
    missing_cycles: int = 0

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
        """Trials with the same one are repeats."""
        return self.gait, self.schedule.cycle_duration_s

    @property
    def promised_s(self) -> float:
        """Seconds that the campaign promises."""
        return (self.schedule.cycles + self.missing_cycles) * self.schedule.period_s

    @property
    def start_said(self) -> bool:
        """Whether labels of a log say when the motion began."""
        return self.t0_spread < UNSURE_CYCLE * self.schedule.cycle_duration_s

    @property
    def read_at(self) -> Floats:
        """Times (R,) [s since t0 on the cameras' clock] of the readings."""
        return self.log_time / (1 + self.clock.rate)

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
    def shape(self) -> ShapeInTime:
        """Joint angles in time, as servos read them; with what the markers show where the log is slow.

        Of what comes after the promised end nothing is known: a servo that is late goes on to its goal, or is let go.
        """
        schedule, log_s = self.schedule, self.read_at
        begun = schedule.period_s * np.arange(schedule.cycles + 1)
        corners = np.unique(np.concatenate([begun, begun[:-1] + schedule.cycle_duration_s]))
        apart = spacing(schedule.cycle_duration_s)
        sources = [Source(log_s, self.position, np.full(self.body.joint_count, READING_SD)).until(self.promised_s)]
        slow = float(np.median(np.diff(log_s)))
        if self.by_servos and apart < PER_KNOT * slow:
            read = fitted(sources, corners, max(apart, slow), carrier=self.carrier)
            shown = self._shown(read)
            if not shown:
                return read
            sources += shown
        sources = [s.until(self.promised_s) for s in sources]
        return fitted(sources, corners, apart, self.carrier is not None or not self.by_servos, self.carrier)

    def _shown(self, read: ShapeInTime) -> list[Source]:
        """Marker angles on the frames, the joints' own zeros taken out, where they are known often enough."""
        shown = marker_angles(self.body, self.markers)
        miss = shown - read.at(self.time)
        if not np.isfinite(miss).sum(axis=0).all():
            return []
        zero = np.nanmedian(miss, axis=0)
        sd = 1.4826 * np.nanmedian(np.abs(miss - zero), axis=0)
        return [Source(self.time, shown - zero, np.maximum(sd, READING_SD))]

    def with_middles(self) -> Recording:
        """The same of the body with vertices in the middles of its edges, which have no markers: see `Body`."""
        markers = np.full((len(self.markers), 2 * self.body.vertices - 1, 2), np.nan)
        markers[:, ::2] = self.markers
        return replace(self, body=self.body.with_middles(), markers=markers)

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
        return float(1.4826 * between / np.sqrt(2) * np.sqrt(count / (count - 3)))

    def angles_at(self, time: Floats) -> Floats:
        """Smoothed joint angles (R, m) at other times."""
        return self.shape.at(time)


def held_out_labels(recordings: Sequence[Recording]) -> tuple[int, ...]:
    """What is held out together: trials of one gait; with a single gait, of one setting; else each trial by itself."""
    kinds: list[list[object]] = [[r.gait for r in recordings], [r.setting for r in recordings]]
    names = next((k for k in kinds if len(set(k)) > 1), list(range(len(recordings))))
    numbers = {name: i for i, name in enumerate(dict.fromkeys(names))}
    return tuple(numbers[name] for name in names)


def read_recordings(
    path: str | Path, progress: Progress | None = None, files: Reader = read_files
) -> tuple[CampaignFile, tuple[Recording, ...]]:
    """All trials of a campaign, each with a joint table and a motion file; InputError that names all that have not.

    What contradicts itself is refused before anything is computed from it (`serpenoid.measure.consistency`).
    files: reads what the campaign names, or has read it.
    """
    file, folder = load_campaign_file(path)
    if not file.lengths_given:
        raise InputError(
            f"{folder}: [body] needs `edge_lengths`: without them shapes and motions cannot be told apart."
        )

    def aligned() -> tuple[Recording, ...]:
        return _aligned(file, *files(file, folder), folder, progress)

    return file, remember(aligned, "recordings", file, content(file, folder))


def _aligned(
    file: CampaignFile, body: Body, read: Sequence[Files], folder: Path, progress: Progress | None
) -> tuple[Recording, ...]:
    """Every trial's clocks aligned; each is kept as soon as it is done."""
    said = believe(file, folder, body, read)
    files = {one.entry.name: one for one in read}

    def kept(entry: TrialEntry) -> Recording:
        own = files[entry.name]
        found = remember(lambda: read_recording(file, own), "recording", file, own)
        _refuse_short(found)
        return replace(found, remarks=(*said.get(entry.name, ()), *_missing(found)))

    return with_one_rate(of_every_trial(file.trial, kept, progress))


def _missing(r: Recording) -> list[str]:
    """Cycles that were promised and not even begun while anything was recorded."""
    first, last = r.schedule.cycles, r.schedule.cycles + r.missing_cycles
    return [f"cycles {first} to {last} are not in the recording: left out"] if last > first else []


def _refuse_short(r: Recording) -> None:
    if r.end < r.schedule.cycle_duration_s / WINDOWS_PER_CYCLE:
        raise InputError(
            f"the recording ends {max(r.end, 0.0):.3g} s after the motion begins: before the first of "
            f"{WINDOWS_PER_CYCLE} windows of a cycle of {r.schedule.cycle_duration_s:g} s. Leave this trial out."
        )


def with_one_rate(recordings: Sequence[Recording]) -> tuple[Recording, ...]:
    """The rate between two devices' clocks is one in all trials; noisy markers tell little of it in each."""
    if not all(r.by_servos and r.clock.rate_sd > 0 for r in recordings):
        return tuple(recordings)
    weight = np.array([1 / r.clock.rate_sd**2 for r in recordings])
    rate = float(weight @ [r.clock.rate for r in recordings] / weight.sum())
    return tuple(_at_rate(r, rate) for r in recordings)


def _at_rate(r: Recording, rate: float) -> Recording:
    """The clock turned about the middle of the film, where it is known best; t0 is the servos'."""
    middle = float(r.time.mean())
    shift = (r.clock.rate - rate) / (1 + rate) * middle
    return replace(r, time=r.time + shift, clock=replace(r.clock, rate=rate))


def read_recording(file: CampaignFile, files: Files) -> Recording:
    """One trial, its clocks aligned."""
    entry, tracks, schedule, log = files.entry, files.tracks, files.schedule, files.servo_log
    if tracks is None or files.labelled is None or schedule is None:
        raise InputError("a diagnosis needs `motion`, `joint_table` and `cycle_duration_s`.")
    markers = files.labelled.vertices / (
        1.0 if tracks.scale_known else neighbour_ratio(files.labelled.vertices, file.body)
    )
    if log is None:
        return _by_markers(file, entry, schedule, tracks.time_s, markers)
    if log.position.shape[1] != file.body.joint_count:
        raise InputError(f"{log.source}: {log.position.shape[1]} joints, the body has {file.body.joint_count}.")
    clock = align(file.body, tracks.time_s, markers, log)
    start = start_on_log(log, schedule, clock.rate) or _start_by_shape(schedule, log.time_s, log.position)
    t0 = (start[0] - clock.zero) / (1 + clock.rate)
    time, log_time = tracks.time_s - t0, log.time_s - start[0]
    shown = schedule.until(max(time[-1], log_time[-1]))
    return Recording(
        entry.name, entry.gait or entry.name, file.body, shown, time, markers, log_time, log.position, clock, start[1],
        commands=log.command, missing_cycles=schedule.cycles - shown.cycles,
    )  # fmt: skip


def _by_markers(file: CampaignFile, entry: TrialEntry, schedule: Schedule, time: Floats, markers: Floats) -> Recording:
    """A trial without a servo log: joint angles are the markers', and the cameras' clock is the only one."""
    refuse_still(time, markers)
    known, shapes_known = angles_shown(file.body, markers)
    t0, spread = _start_by_shape(schedule, time[known], shapes_known)
    filmed = schedule.until(time[-1] - t0)
    return Recording(
        entry.name, entry.gait or entry.name, file.body, filmed, time - t0, markers, time - t0,
        angles_read(file.body, markers, known, shapes_known),
        Clock(0.0, 0.0, 0.0, 0.0), spread, by_servos=False, missing_cycles=schedule.cycles - filmed.cycles,
    )  # fmt: skip


def _start_by_shape(schedule: Schedule, time: Floats, angles: Floats) -> tuple[float, float]:
    found = start_by_shape(schedule, time, angles)
    if found is None or found.correlation < MIN_CORRELATION:
        raise InputError(
            "nothing says when the motion began, and the joint table is not found in the recorded shapes. Another "
            "gait's table, joints in another order, or markers not tail first?"
        )
    return found.offset_s, UNSURE_CYCLE * schedule.cycle_duration_s
