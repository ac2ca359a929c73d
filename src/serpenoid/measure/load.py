"""A campaign folder as frozen trials: files read, promises checked, clocks aligned, cycles cut."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from serpenoid.body import Body
from serpenoid.errors import InputError
from serpenoid.measure.animal import remarks
from serpenoid.measure.campaign import CampaignFile, TrialEntry, load_campaign_file
from serpenoid.measure.cells import Floats
from serpenoid.measure.consistency.claims import believe
from serpenoid.measure.tracks import Tracks
from serpenoid.measure.trial import Passage, Trial, build_motion, cut_passages, schedule_start
from serpenoid.measure.trial_files import Files, Progress, neighbour_ratio, read_files, read_trial
from serpenoid.store import file_digest, remember


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
    """Read a campaign folder. Every broken trial is named in one InputError; nothing is half-read.

    What contradicts itself is refused before anything is computed from it (`serpenoid.measure.consistency`).
    """
    file, folder = load_campaign_file(path)
    inputs = ("campaign", file, [(str(p), file_digest(p)) for p in _inputs(file, folder)])
    body, trials = remember(lambda: _aligned(file, folder, progress), *inputs)
    return Campaign(file, folder, body, not file.lengths_given, trials)


def _inputs(file: CampaignFile, folder: Path) -> list[Path]:
    """Every file that a campaign is made from, and the joint tables it is compared with."""
    named = [n for t in file.trial for n in (t.joint_table, t.motion, t.servo_log, t.power_log) if n is not None]
    tables = {(folder / t.joint_table).parent for t in file.trial if t.joint_table is not None}
    beside = [path for place in sorted(tables) for path in sorted(place.glob("*.csv"))]
    return [path.resolve() for path in dict.fromkeys([*(folder / n for n in named), *beside])]


def _aligned(file: CampaignFile, folder: Path, progress: Progress | None) -> tuple[Body, tuple[Trial, ...]]:
    """The body, and every trial aligned; each is kept as soon as it is done."""
    body, read = read_files(file, folder, progress)
    said = believe(file, folder, body, read)
    trials, faults = [], []
    for files in read:
        try:
            trial = remember(lambda: align_trial(file, files, body), "trial", file, files, body)  # noqa: B023
            trials.append(replace(trial, notes=trial.notes + said.get(trial.name, ())))
        except InputError as error:
            faults.append(f"trial `{files.entry.name}`: {error}")
    if faults:
        raise InputError("\n".join(faults))
    return body, tuple(trials)


def load_trial(file: CampaignFile, entry: TrialEntry, folder: Path, body: Body) -> Trial:
    """Read one trial's files and align them, unchecked against the rest of the campaign."""
    return align_trial(file, read_trial(file, entry, folder), body)


def align_trial(file: CampaignFile, files: Files, body: Body) -> Trial:
    """Clocks laid over each other, the chain fitted, cycles cut."""
    entry, tracks, labelled, schedule = files.entry, files.tracks, files.labelled, files.schedule
    motion = servo = None
    notes: list[str] = []
    passages: tuple[Passage, ...] = ()
    source = "none"
    metres = body.total_length_m if file.lengths_given else None
    if tracks is not None and labelled is not None:
        scale = _scale(tracks, labelled.vertices, body, file.lengths_given)
        metres = body.total_length_m if tracks.scale_known and files.keys.length_unit != "bl" else None
        extras = (labelled.relabelled, labelled.unused)
        motion, servo, notes = build_motion(body, tracks.time_s, labelled.vertices / scale, files.servo_log, extras)
    if schedule is not None:
        schedule, source, complaints = schedule_start(schedule, files.servo_log, servo, motion)
        notes += complaints
    if motion is not None:
        passages, complaints = cut_passages(motion, schedule if source != "none" else None)
        notes += complaints
        notes += remarks(motion) if file.tracked_only else ()
    return Trial(
        entry.name, entry.gait or entry.name, body, metres, schedule, source, motion, servo, files.servo_log,
        files.power_log, passages, entry.dissipation_coefficient, tuple(notes),
    )  # fmt: skip


def _scale(tracks: Tracks, vertices: Floats, body: Body, lengths_given: bool) -> float:
    """File units per body length; where the file's unit is unknown, as its neighbouring markers say."""
    if not lengths_given or tracks.scale_known:
        return body.total_length_m
    ratio = neighbour_ratio(vertices, body)
    if not np.isfinite(ratio):
        raise InputError(f"{tracks.source}: no two neighbouring markers are ever seen together.")
    return ratio * body.total_length_m
