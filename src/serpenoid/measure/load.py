"""A campaign folder as frozen trials: files read, promises checked, clocks aligned, cycles cut."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from serpenoid.body import Body
from serpenoid.errors import InputError
from serpenoid.files.store import remember
from serpenoid.measure.animals.animal import remarks
from serpenoid.measure.animals.film_scale import FilmScale, film_scale
from serpenoid.measure.campaign import CampaignFile, load_campaign_file
from serpenoid.measure.cells import Floats
from serpenoid.measure.consistency.claims import believe
from serpenoid.measure.consistency.still import nothing_moved
from serpenoid.measure.consistency.unplayed import as_filmed, unplayed
from serpenoid.measure.link_lengths import hidden_lengths
from serpenoid.measure.remark import Remark, remarks_of
from serpenoid.measure.tracks import Tracks
from serpenoid.measure.trial import Motion, Passage, Trial, build_motion, cut_passages, log_covers, schedule_start
from serpenoid.measure.trial_files import Files, Progress, kept_of_files, of_every_trial, other_lengths, read_files
from serpenoid.parallel import Workers, results

ALONE = Workers()


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


def load_campaign(path: str | Path, progress: Progress | None = None, workers: Workers = ALONE) -> Campaign:
    """Read a campaign folder. Every broken trial is named in one InputError; nothing is half-read.

    What contradicts itself is refused before anything is computed from it (`serpenoid.measure.consistency`).
    """
    file, folder = load_campaign_file(path)
    try:
        body, trials = kept_of_files("campaign", file, folder, lambda: _aligned(file, folder, progress, workers))
    except InputError as error:
        if not str(error).startswith("["):  # a section: of which file?
            raise
        raise InputError(f"{path}: {error}") from None
    return Campaign(file, folder, body, not file.lengths_given, trials)


def with_other_lengths(campaign: Campaign, blocks: int) -> tuple[Campaign, ...]:
    """The campaign with edge lengths estimated without one of `blocks` parts of its frames, for every part.

    How far their fits differ is what not knowing the lengths does. Passages are the campaign's own; none where lengths
    are given.
    """
    if not campaign.lengths_estimated:
        return ()
    file, folder = campaign.file, campaign.folder
    others = kept_of_files("other lengths", file, folder, lambda: _other_lengths(campaign, blocks), blocks)
    return tuple(replace(campaign, body=body, trials=trials) for body, trials in others)


def _other_lengths(campaign: Campaign, blocks: int) -> tuple[tuple[Body, tuple[Trial, ...]], ...]:
    _, read = read_files(campaign.file, campaign.folder)
    found = []
    for lengths in other_lengths(campaign.body, read, blocks):
        body = Body.model_validate(campaign.body.model_dump() | {"edge_lengths": tuple(lengths.tolist())})
        made = [align_trial(campaign.file, f, body, t.motion) for f, t in zip(read, campaign.trials, strict=True)]
        trials = tuple(replace(m, passages=t.passages) for m, t in zip(made, campaign.trials, strict=True))
        found.append((body, trials))
    return tuple(found)


def with_other_scales(campaign: Campaign) -> tuple[Trial, ...]:
    """Of every film whose scale is found from itself: the trial, were it larger by a standard error."""
    unsure = {trial.name: trial for trial in campaign.trials if trial.scale_sd > 0}
    if not unsure:
        return ()
    file, folder = campaign.file, campaign.folder
    return kept_of_files("other scales", file, folder, lambda: _other_scales(campaign, unsure), tuple(unsure))


def _other_scales(campaign: Campaign, unsure: Mapping[str, Trial]) -> tuple[Trial, ...]:
    _, read = read_files(campaign.file, campaign.folder)
    found = []
    for files in read:
        if (trial := unsure.get(files.entry.name)) is not None:
            made = align_trial(campaign.file, files, campaign.body, trial.motion, 1 + trial.scale_sd)
            found.append(replace(made, passages=trial.passages))
    return tuple(found)


def _aligned(
    file: CampaignFile, folder: Path, progress: Progress | None, workers: Workers
) -> tuple[Body, tuple[Trial, ...]]:
    """The body, and every trial aligned; each is kept as soon as it is done."""
    body, read = read_files(file, folder)
    read, said = believe(file, folder, body, read)
    found: dict[str, Trial | InputError] = {}
    for index, trial in results(_kept, [(file, files, body) for files in read], workers):
        if progress is not None:
            progress(len(found), len(read), read[index].entry.name)
        found[read[index].entry.name] = trial
    trials = of_every_trial(file.trial, lambda entry: _whole(found[entry.name]))
    hidden = hidden_lengths(body, trials) if file.lengths_given else ""
    more = (Remark(hidden),) if hidden else ()
    return body, tuple(replace(trial, remarks=trial.remarks + said.get(trial.name, ()) + more) for trial in trials)


def _kept(file: CampaignFile, files: Files, body: Body) -> Trial | InputError:
    """One trial from an earlier run or aligned; a fault is a value, so that the others are aligned too."""
    try:
        return remember(lambda: align_trial(file, files, body), "trial", file, files, body)
    except InputError as error:
        return error


def _whole(found: Trial | InputError) -> Trial:
    if isinstance(found, InputError):
        raise found
    return found


def align_trial(file: CampaignFile, files: Files, body: Body, like: Motion | None = None, larger: float = 1.0) -> Trial:
    """Clocks laid over each other, the chain fitted, cycles cut; like: the motion that says where it has holes; larger:
    times the scale that the film has."""
    entry, tracks, labelled, schedule = files.entry, files.tracks, files.labelled, files.schedule
    motion = servo = None
    notes: list[str] = []
    passages: tuple[Passage, ...] = ()
    source = "none"
    metres = body.total_length_m if file.lengths_given else None
    scale_sd = 0.0
    if tracks is not None and labelled is not None:
        scale = _scale(tracks, labelled.vertices, body, file.lengths_given)
        scale_sd = scale.sd
        metres = body.total_length_m if tracks.scale_known and files.keys.length_unit != "bl" else None
        extras = (labelled.relabelled, labelled.unused)
        motion, servo, notes = build_motion(
            body, tracks.time_s, labelled.vertices / (larger * scale.ratio), files.servo_log, extras, like, schedule
        )
    if scale_sd > 0:
        notes = [*notes, scale.words]
    if metres is not None:
        notes = [*notes, *(said for said in (body.odd_length, body.odd_mass) if said)]
    if schedule is not None and motion is not None:
        promised = schedule.cycles
        schedule = as_filmed(schedule, motion.time_s, motion.joint_angles, files.servo_log)
        notes += [unplayed(promised, schedule.cycles)] if schedule.cycles < promised else []
    if schedule is not None:
        schedule, source, complaints = schedule_start(schedule, files.servo_log, servo, motion)
        notes += complaints
        if source != "none" and servo is not None and files.servo_log is not None:
            notes += log_covers(schedule, files.servo_log.time_s + servo.offset.offset_s)
    if motion is not None:
        notes += [labelled.said] if labelled is not None and labelled.said else []
        passages, complaints = cut_passages(motion, schedule if source != "none" else None, files.servo_log)
        notes += complaints
        still = nothing_moved(motion.time_s, motion.markers)
        notes += [still] if still else remarks(body, motion, file.lengths_given) if file.tracked_only else ()
    return Trial(
        entry.name, entry.gait or entry.name, body, metres, schedule, source, motion, servo, files.servo_log,
        files.power_log, passages, entry.dissipation_coefficient, remarks_of(notes), scale_sd,
    )  # fmt: skip


def _scale(tracks: Tracks, vertices: Floats, body: Body, lengths_given: bool) -> FilmScale:
    """File units per body length; where the file's unit is unknown, as its neighbouring markers say."""
    if not lengths_given or tracks.scale_known:
        return FilmScale(body.total_length_m, 0.0)
    found = film_scale(body, vertices)
    if not np.isfinite(found.ratio):
        raise InputError(f"{tracks.source}: no two neighbouring markers are ever seen together.")
    return replace(found, ratio=found.ratio * body.total_length_m)
