"""A campaign folder as frozen trials: files read, markers mapped, clocks aligned, cycles cut."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from serpenoid.body import Body
from serpenoid.errors import InputError
from serpenoid.measure.campaign import (
    CampaignFile,
    MotionKeys,
    TrialEntry,
    load_campaign_file,
    read_motion,
    read_table,
)
from serpenoid.measure.cells import Floats
from serpenoid.measure.logs import read_power_log, read_servo_log
from serpenoid.measure.relabel import Labelled, label_vertices
from serpenoid.measure.schedule import Schedule
from serpenoid.measure.tracks import Tracks
from serpenoid.measure.trial import Passage, Trial, build_motion, cut_passages, schedule_start

Progress = Callable[[int, int, str], None]
UNIT_HINTS = {
    1000.0: "Is the file in mm?",
    100.0: "Is the file in cm?",
    0.001: "Is the file in m and says mm, or is the body in mm?",
    0.01: "Is the file in m and says cm, or is the body in cm?",
}


@dataclass(frozen=True)
class Campaign:
    """All trials of one folder, and the body they share."""

    file: CampaignFile
    folder: Path
    body: Body
    lengths_estimated: bool
    trials: tuple[Trial, ...]

    @property
    def gaits(self) -> dict[str, tuple[Trial, ...]]:
        """Gait label -> its repeats."""
        labels = dict.fromkeys(trial.gait for trial in self.trials)
        return {label: tuple(trial for trial in self.trials if trial.gait == label) for label in labels}


def load_campaign(path: str | Path, progress: Progress | None = None) -> Campaign:
    """Read a campaign folder. Every broken trial is named in one InputError; nothing is half-read."""
    file, folder = load_campaign_file(path)
    body = file.body if file.lengths_given else _estimate_lengths(file, folder)
    trials, faults = [], []
    for index, entry in enumerate(file.trial):
        if progress is not None:
            progress(index, len(file.trial), entry.name)
        try:
            trials.append(load_trial(file, entry, folder, body))
        except InputError as error:
            faults.append(f"trial `{entry.name}`: {error}")
    if faults:
        raise InputError("\n".join(faults))
    return Campaign(file, folder, body, not file.lengths_given, tuple(trials))


def load_trial(file: CampaignFile, entry: TrialEntry, folder: Path, body: Body) -> Trial:
    """Read one trial's files and align them."""
    table = read_table(entry, body, folder)
    log = read_servo_log(folder / entry.servo_log) if entry.servo_log else None
    power = read_power_log(folder / entry.power_log) if entry.power_log else None
    schedule = _schedule(entry, table)
    tracks = read_motion(file, entry, folder)
    motion = servo = None
    notes: list[str] = []
    passages: tuple[Passage, ...] = ()
    metres = body.total_length_m if file.lengths_given else None
    if tracks is not None:
        keys = file.motion_of(entry)
        labelled = label_markers(tracks, keys, body.edges_m if tracks.scale_known else None, body.vertices)
        scale = _scale(tracks, labelled.vertices, body, file.lengths_given)
        metres = body.total_length_m if tracks.scale_known and keys.length_unit != "bl" else None
        extras = (labelled.relabelled, labelled.unused)
        motion, servo, notes = build_motion(body, tracks.time_s, labelled.vertices / scale, log, extras)
    source = "none"
    if schedule is not None:
        schedule, source, complaints = schedule_start(schedule, log, servo, motion)
        notes += complaints
    if motion is not None:
        passages, complaints = cut_passages(motion, schedule if source != "none" else None)
        notes += complaints
    return Trial(
        entry.name, entry.gait or entry.name, body, metres, schedule, source, motion, servo, log, power, passages,
        entry.dissipation_coefficient, tuple(notes),
    )  # fmt: skip


def _schedule(entry: TrialEntry, table: Floats | None) -> Schedule | None:
    if table is None or entry.cycle_duration_s is None:
        return None
    return Schedule(table, entry.cycle_duration_s, entry.cycles or 1, entry.pause_s)


def label_markers(tracks: Tracks, keys: MotionKeys, edges: Floats | None, count: int) -> Labelled:
    """Tracks as vertices 0 .. N - 1 (N = `count`), by marker names and edge lengths (N - 1,), if known."""
    markers = None if keys.format == "tidy" else keys.markers  # tidy columns are vertices already
    return label_vertices(tracks, markers, edges, count, keys.first_point == "head")


def _estimate_lengths(file: CampaignFile, folder: Path) -> Body:
    """The body with edge lengths = medians of the distances between neighbouring markers over all recordings."""
    distances = []
    for entry in file.trial:
        tracks = read_motion(file, entry, folder)
        if tracks is not None:
            labelled = label_markers(tracks, file.motion_of(entry), None, file.body.vertices)
            distances.append(np.linalg.norm(np.diff(labelled.vertices, axis=1), axis=2))
    if not distances:
        raise InputError("[body] has no lengths and no trial has a motion file to estimate them from.")
    edges = np.nanmedian(np.concatenate(distances), axis=0)
    if not np.isfinite(edges).all() or (edges <= 0).any():
        raise InputError("[body] has no lengths, and some neighbouring markers are never seen together.")
    return file.body.model_copy(update={"edge_lengths": tuple(edges.tolist())})


def _scale(tracks: Tracks, vertices: Floats, body: Body, lengths_given: bool) -> float:
    """File units per body length; a length unit that cannot be right is refused."""
    if not lengths_given:
        return body.total_length_m
    distances = np.linalg.norm(np.diff(vertices, axis=1), axis=2)
    ever = np.isfinite(distances).any(axis=0)  # an end of the others is hidden throughout
    measured = np.nanmedian(distances[:, ever], axis=0)
    ratio = float(np.nanmedian(measured / body.edges_m[ever])) if ever.any() else np.nan
    if not np.isfinite(ratio):
        raise InputError(f"{tracks.source}: no two neighbouring markers are ever seen together.")
    if not tracks.scale_known:
        return ratio * body.total_length_m
    if not 0.7 < ratio < 1.4:
        hint = next((f" {words}" for factor, words in UNIT_HINTS.items() if 0.7 < ratio / factor < 1.4), "")
        raise InputError(
            f"{tracks.source}: neighbouring markers are {ratio:.4g} times as far apart as [body] says "
            f"(median {np.nanmedian(measured):.4g} m).{hint} Check `length_unit`, `edge_lengths` and `markers`."
        )
    return body.total_length_m
