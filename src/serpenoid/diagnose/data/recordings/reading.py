"""From a campaign's files to recordings: clocks aligned, the beginning of the motion found, contradictions refused."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.recordings.clocks import (
    Clock,
    align,
    as_played,
    beside_plan,
    pooled,
    run_apart,
    start_on_log,
)
from serpenoid.diagnose.data.recordings.played import at_played_rate, by_their_commands
from serpenoid.diagnose.data.recordings.put_elsewhere import with_puts
from serpenoid.diagnose.data.recordings.recording import UNSURE_CYCLE, WINDOWS_PER_CYCLE, Recording
from serpenoid.diagnose.data.recordings.single_markers import beside_log, without_single
from serpenoid.diagnose.data.recordings.told import told_by_commands
from serpenoid.diagnose.data.shapes.shapes_from_points import angles_read, angles_shown
from serpenoid.diagnose.data.still import refuse_still
from serpenoid.errors import InputError
from serpenoid.files.store import remember
from serpenoid.measure.animals.film_scale import film_scale
from serpenoid.measure.campaign import CampaignFile, TrialEntry, load_campaign_file
from serpenoid.measure.clock import Offset
from serpenoid.measure.consistency.claims import Reader, read_believed
from serpenoid.measure.consistency.films import films_of
from serpenoid.measure.consistency.lengths import all_longer, taken_for_scale
from serpenoid.measure.consistency.unplayed import as_filmed
from serpenoid.measure.remark import Remark, remarks_of
from serpenoid.measure.schedule import Schedule, start_by_shape
from serpenoid.measure.servo_alignment import MIN_CORRELATION, assumed, seen_corners, start_by_corners
from serpenoid.measure.shapes.links import marker_angles
from serpenoid.measure.trial_files import Files, Progress, kept_of_files, of_every_trial


def read_recordings(
    path: str | Path, progress: Progress | None = None, files: Reader = read_believed
) -> tuple[CampaignFile, tuple[Recording, ...]]:
    """All trials of a campaign, each with a joint table and a motion file; InputError that names all that have not.

    What contradicts itself is refused before anything is computed from it (`serpenoid.measure.consistency`).
    files: reads what the campaign names and checks it against itself, or has done so.
    """
    file, folder = load_campaign_file(path)
    if not file.lengths_given:
        raise InputError(
            f"{folder}: [body] needs `edge_lengths`: without them shapes and motions cannot be told apart."
        )

    def aligned() -> tuple[Recording, ...]:
        return _aligned(file, *files(file, folder)[1:], progress)

    return file, kept_of_files("recordings", file, folder, aligned)


def _aligned(
    file: CampaignFile, read: Sequence[Files], said: Mapping[str, tuple[Remark, ...]], progress: Progress | None
) -> tuple[Recording, ...]:
    """Every trial's clocks aligned; each is kept as soon as it is done. said: remarks by the trial's name."""
    read, said = _scaled(file, read, said)
    files = {one.entry.name: one for one in read}

    def kept(entry: TrialEntry) -> Recording:
        own = files[entry.name]
        found = remember(lambda: read_recording(file, own), "recording", file, own)
        _refuse_short(found)
        own_words = [*_missing(found, own), *_assumed(found), *_unread(own)]
        return replace(found, remarks=(*said.get(entry.name, ()), *remarks_of(own_words)))

    found = at_played_rate(by_their_commands(with_one_rate(of_every_trial(file.trial, kept, progress))))
    return with_puts(found)


def _scaled(
    file: CampaignFile, read: Sequence[Files], said: Mapping[str, tuple[Remark, ...]]
) -> tuple[Sequence[Files], Mapping[str, tuple[Remark, ...]]]:
    """Films of robots without servo logs in the scale in which links are as long as stated, all alike or each in its
    own, and that said: shapes are what markers show, and chains of other lengths would bend otherwise. With a log it is
    found as an effect."""
    kinds = {r.kind for own in said.values() for r in own}
    if not kinds & {"scale", "cameras"}:
        return read, said
    if any(f.servo_log is not None and not f.servo_log.repeats_commands for f in read):
        return read, said
    films = films_of(file, file.body, read)
    if films is None:
        return read, said
    share = all_longer(films.shown[0]) if "scale" in kinds else None
    scales = films.scales if share is None else dict.fromkeys(films.trials, float(np.log1p(share)))
    taken = films.taken(scales) if share is None else dict.fromkeys(films.trials, Remark(taken_for_scale(share)))
    as_stated = [
        replace(f, labelled=replace(f.labelled, vertices=f.labelled.vertices / np.exp(scales[f.entry.name])))
        if f.labelled is not None and f.entry.name in scales
        else f
        for f in read
    ]
    kind = "cameras" if share is None else "scale"
    return as_stated, {
        name: tuple(taken.get(name, r) if r.kind == kind else r for r in own) for name, own in said.items()
    }


def _unread(files: Files) -> list[str]:
    """Of a log that has no readings."""
    said = (
        "the log's positions are its commands, to the last digit: servos are not read, and shapes are what markers show"
    )
    return [said] if files.servo_log is not None and files.servo_log.repeats_commands else []


def _missing(r: Recording, files: Files) -> list[str]:
    """Cycles that were promised and are over before anything is recorded, or not even begun while it is, or never."""
    s = r.schedule
    promised = s.cycles + r.missing_cycles
    over = s.period_s * np.arange(s.cycles) + s.cycle_duration_s
    before = int((over < max(r.time[0], r.read_at[0])).sum())
    said = []
    if before:
        said.append(
            f"of {promised} promised cycles, {before} would be over before the recording begins: is `cycles` right?"
        )
    if r.missing_cycles:
        said.append(f"of {promised} promised cycles, {r.missing_cycles} would begin after the recording: left out")
    if r.unplayed_cycles:
        of = promised + r.unplayed_cycles
        said.append(f"{promised} of {of} promised cycles were played, {_who_says(files, promised)}")
    return said


def _who_says(files: Files, played: int) -> str:
    """Whence so many cycles are known, fewer than promised."""
    log, schedule = files.servo_log, files.schedule
    by_labels = log is not None and schedule is not None and as_played(log, schedule).cycles == played
    return "say the log's labels" if by_labels else "say the film and what servos read"


def _assumed(r: Recording) -> list[str]:
    """Joints of which nothing is read."""
    unread = np.flatnonzero(~np.isfinite(r.position).any(axis=0))
    return [assumed(unread.tolist())] if len(unread) and not r.by_servos else []


def _refuse_short(r: Recording) -> None:
    if r.end < r.schedule.cycle_duration_s / WINDOWS_PER_CYCLE:
        raise InputError(
            f"the recording ends {max(r.end, 0.0):.3g} s after the motion begins: before the first of "
            f"{WINDOWS_PER_CYCLE} windows of a cycle of {r.schedule.cycle_duration_s:g} s. Leave this trial out."
        )


def with_one_rate(recordings: Sequence[Recording]) -> tuple[Recording, ...]:
    """The rate between two devices' clocks is one in all trials, as noisy markers tell little of it in each; unless
    they tell that it is not."""
    clocks = [r.clock for r in recordings]
    told = all(r.by_servos and c.rate_sd > 0 for r, c in zip(recordings, clocks, strict=True))
    if not told or run_apart(clocks, [r.setting for r in recordings]):
        return tuple(recordings)
    rate, _ = pooled([r.clock for r in recordings])
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
        1.0 if tracks.scale_known else film_scale(file.body, files.labelled.vertices).ratio
    )
    markers, strays = without_single(file.body, tracks.time_s, markers)
    if log is None or log.repeats_commands:
        return replace(_by_markers(file, entry, schedule, tracks.time_s, markers), strays=strays)
    clock = align(file.body, tracks.time_s, markers, log)
    filmed = as_filmed(schedule, tracks.time_s, marker_angles(file.body, markers), log)
    promised, schedule = schedule.cycles, as_played(log, filmed)
    labelled = start_on_log(log, schedule, clock.rate)
    told = told_by_commands(log, schedule, clock.rate, labelled[0] if labelled else None)
    if told:
        begun, slower = told.start_s, 1.0 if told.by_log else 1 + clock.rate

        def plan(time: Floats) -> Floats:
            return schedule.commanded((time - begun) / slower)

        followed = None if told.held else plan  # servos are late for rows that jump: corners would be in the difference
        clock = beside_plan(clock, file.body, tracks.time_s, markers, log, followed)
    start = (told.start_s, told.spread_s) if told else labelled
    start = start or _start(schedule, start_by_shape(schedule, log.time_s, log.position))
    if labelled is None:
        start = _shown_first(schedule, start[0], float(log.time_s[0])), start[1]
    t0 = (start[0] - clock.zero) / (1 + clock.rate)
    time, log_time = tracks.time_s - t0, log.time_s - start[0]
    shown = schedule.until(max(time[-1], log_time[-1]))
    found = Recording(
        entry.name, entry.gait or entry.name, file.body, shown, time, markers, log_time, log.position, clock, start[1],
        commands=log.command, missing_cycles=schedule.cycles - shown.cycles, unplayed_cycles=promised - schedule.cycles,
        told=told, strays=strays,
    )  # fmt: skip
    return beside_log(found)


def _by_markers(file: CampaignFile, entry: TrialEntry, schedule: Schedule, time: Floats, markers: Floats) -> Recording:
    """A trial without a servo log: joint angles are the markers', and the cameras' clock is the only one."""
    refuse_still(time, markers)
    known, shapes_known = angles_shown(file.body, markers)
    if seen_corners(file.body, markers) == list(file.body.corners):
        found = start_by_shape(schedule, time[known], shapes_known)
    else:  # a vertex that is guessed from its neighbours has two mirror positions
        found = start_by_corners(file.body, schedule, markers, time)
    t0, spread = _start(schedule, found)
    filmed = schedule.until(time[-1] - t0)
    return Recording(
        entry.name, entry.gait or entry.name, file.body, filmed, time - t0, markers, time - t0,
        angles_read(file.body, markers, known, shapes_known),
        Clock(0.0, 0.0, 0.0, 0.0), spread, by_servos=False, missing_cycles=schedule.cycles - filmed.cycles,
    )  # fmt: skip


def _shown_first(schedule: Schedule, start: float, first: float) -> float:
    """When the motion began, of a log from a time on: cycles are alike, and where no label numbers them those that are
    over before it begins are none. A trial that was aborted has fewer than it promises, at its end."""
    over = first - start - schedule.cycle_duration_s
    return start + max(int(over // schedule.period_s) + 1, 0) * schedule.period_s


def _start(schedule: Schedule, found: Offset | None) -> tuple[float, float]:
    """When the motion began, and how unsure that is."""
    if found is None or found.correlation < MIN_CORRELATION:
        raise InputError(
            "nothing says when the motion began, and the joint table is not found in the recorded shapes. Another "
            "gait's table, joints in another order, or markers not tail first?"
        )
    return found.offset_s, UNSURE_CYCLE * schedule.cycle_duration_s
