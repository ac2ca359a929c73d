"""One trial as the diagnosis needs it: what was commanded, what servos read, what cameras saw; SI, from t0 on.

Shapes come from the servos, smoothed by local parabolas within each stretch of playing or pause: unsmoothed ticks in
the joint rates would be rectified by every law with a sign in it, and look like friction.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.signal import savgol_filter

from serpenoid.body import Body, Floats
from serpenoid.diagnose.clocks import Clock, align, start_on_log
from serpenoid.errors import InputError
from serpenoid.measure.campaign import CampaignFile, TrialEntry, load_campaign_file, read_motion, read_table
from serpenoid.measure.chain import marker_angles
from serpenoid.measure.logs import ServoLog, read_servo_log
from serpenoid.measure.schedule import Schedule, start_by_shape
from serpenoid.measure.trial_files import label_markers

SMOOTHED_S = 0.175  # local parabolas over this time


@dataclass(frozen=True)
class Recording:
    """time (F,) [s since t0 on the cameras' clock], markers (F, N, 2) [m], NaN hidden; the log on its own clock.

    log_time (R,): servo clock, seconds since t0, not corrected for its rate (`clock.rate`); position (R, m) [rad].
    t0_spread: how far t0 may be off [s].
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

    @property
    def setting(self) -> tuple[str, float]:
        """Trials with the same one are repeats."""
        return self.gait, self.schedule.cycle_duration_s

    @property
    def end(self) -> float:
        """Last moment that both schedule and cameras cover [s]."""
        return float(min(self.schedule.cycles * self.schedule.period_s, self.time[-1]))

    def stretch(self, time: Floats) -> np.ndarray:
        """Label of the stretch each time lies in: -1 before t0, 2 n while cycle n is played, 2 n + 1 in its pause."""
        cycle = np.clip(np.floor(time / self.schedule.period_s), 0, self.schedule.cycles - 1)
        pause = time - cycle * self.schedule.period_s >= self.schedule.cycle_duration_s
        return np.where(time < 0, -1, 2 * cycle + pause).astype(int)

    @cached_property
    def angles(self) -> Floats:
        """Servo readings (F, m) on the camera frames, smoothed."""
        at = (1 + self.clock.rate) * self.time
        raw = np.stack([np.interp(at, self.log_time, column) for column in self.position.T], axis=1)
        window = 2 * int(SMOOTHED_S / np.median(np.diff(self.time)) / 2) + 1
        smooth, label = raw.copy(), self.stretch(self.time)
        for one in np.unique(label):
            mine = label == one
            if mine.sum() > window:
                smooth[mine] = savgol_filter(raw[mine], window, 2, axis=0)
        return smooth

    def angles_at(self, time: Floats) -> Floats:
        """Smoothed joint angles (R, m) at other times."""
        return np.stack([np.interp(time, self.time, column) for column in self.angles.T], axis=1)


Progress = Callable[[int, int, str], None]


def read_recordings(path: str | Path, progress: Progress | None = None) -> tuple[CampaignFile, tuple[Recording, ...]]:
    """All trials of a campaign that have a joint table, a servo log and a motion file; InputError where none has."""
    file, folder = load_campaign_file(path)
    if not file.lengths_given:
        raise InputError(
            f"{folder}: [body] needs `edge_lengths`: without them shapes and motions cannot be told apart."
        )
    found, faults = [], []
    for index, entry in enumerate(file.trial):
        if progress is not None:
            progress(index, len(file.trial), entry.name)
        try:
            found.append(read_recording(file, entry, folder))
        except InputError as error:
            faults.append(f"trial `{entry.name}`: {error}")
    if faults:
        raise InputError("\n".join(faults))
    return file, tuple(found)


def read_recording(file: CampaignFile, entry: TrialEntry, folder: Path) -> Recording:
    """One trial, its clocks aligned."""
    tracks, table = read_motion(file, entry, folder), read_table(entry, file.body, folder)
    if tracks is None or table is None or entry.servo_log is None or entry.cycle_duration_s is None:
        raise InputError("a diagnosis needs `motion`, `servo_log`, `joint_table` and `cycle_duration_s`.")
    log = read_servo_log(folder / entry.servo_log)
    if log.position.shape[1] != file.body.joint_count:
        raise InputError(f"{log.source}: {log.position.shape[1]} joints, the body has {file.body.joint_count}.")
    schedule = Schedule(table, entry.cycle_duration_s, entry.cycles or 1, entry.pause_s)
    markers = label_markers(tracks, file.motion_of(entry), file.body.edges_m, file.body.vertices).vertices
    angles = marker_angles(file.body, markers)
    clock = align(tracks.time_s, angles, log)
    start = start_on_log(log, schedule, clock.rate) or _start_by_shape(schedule, log)
    t0 = (start[0] - clock.zero) / (1 + clock.rate)
    return Recording(
        entry.name, entry.gait or entry.name, file.body, schedule, tracks.time_s - t0, markers, log.time_s - start[0],
        log.position, clock, start[1],
    )  # fmt: skip


def _start_by_shape(schedule: Schedule, log: ServoLog) -> tuple[float, float]:
    found = start_by_shape(schedule, log.time_s, log.position)
    if found is None:
        raise InputError("the log does not say when the motion began, and the joint table does not match it.")
    return found.offset_s, 0.01
