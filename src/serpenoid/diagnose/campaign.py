"""A campaign's folder, diagnosed: read as a robot's or as an animal's, beside a baseline or an earlier campaign."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from serpenoid.diagnose.changed_trials import changed_trials
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.tracked import tracked_recordings
from serpenoid.diagnose.data.windows.tracks import NoPath
from serpenoid.diagnose.diagnose import Diagnosis, diagnose, diagnose_tracked
from serpenoid.diagnose.drag_ratio import drag_ratio_of
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.ladder import Climbed
from serpenoid.diagnose.stages.motion.choose_motion import Searched
from serpenoid.diagnose.start import (
    at_middles,
    baseline,
    check_body,
    law_is_open,
    rootless,
    taken_for_granted,
    unlike_body,
    unlike_kind,
)
from serpenoid.errors import InputError
from serpenoid.measure.campaign import CampaignFile, load_campaign_file
from serpenoid.measure.consistency.claims import Reader, read_believed
from serpenoid.measure.load import load_campaign


@dataclass(frozen=True)
class Listener:
    """Who hears how a diagnosis goes on; by default nobody.

    reading: trials read, of how many, name of the next. say: the stage that begins. notice: before the work begins,
    what of a long recording is left out. searched: what the search for effects of the motion found, as soon as it has
    ended. climbed: the ladder's steps from command to markers.
    """

    reading: Callable[[int, int, str], None] = lambda done, total, name: None
    say: Callable[[str], None] = lambda stage: None
    notice: Callable[[str], None] = lambda text: None
    searched: Searched = lambda found: None
    climbed: Climbed = lambda steps: None


NOBODY = Listener()


def diagnose_campaign(
    campaign: str | Path,
    model: str | Path | None = None,
    earlier: Baseline | None = None,
    without: frozenset[str] = frozenset(),
    files: Reader = read_believed,
    listener: Listener = NOBODY,
    apart: bool = True,
) -> tuple[CampaignFile, Diagnosis]:
    """One campaign, beside what was so earlier or beside the model alone; the motion alone where points are all.

    without: names of effects that are not looked for. files: reads what a robot's campaign names and checks it, or has
    done so. apart: whether trials in which something acts alone are diagnosed by themselves, too; of a reference nobody
    asks.
    """
    file, _ = load_campaign_file(campaign)
    if file.tracked_only:
        if earlier is not None:
            raise InputError(f"{campaign}: has tracked points alone, so no other campaign repeats its shapes.")
        if unlike := unlike_kind(model, file):
            listener.notice(unlike)
        read = load_campaign(campaign, listener.reading)
        tracked = tracked_recordings(read)
        for recording in tracked:
            if recording.shortened:
                listener.notice(f"{recording.name}: {recording.shortened}")
        begun = baseline(model, file, tracked[0].body)
        known = taken_for_granted(begun, law_is_open(model, file), without, listener.notice)
        found = diagnose_tracked(tracked, known, listener.say, listener.searched)
        return file, replace(found, drag_ratio=drag_ratio_of(found, read, begun.medium))
    check_body(model, file)
    if unlike := unlike_body(model, file):
        listener.notice(unlike)
    pieces = at_middles(model, file)
    body = file.body.with_middles(pieces) if pieces else file.body
    if pieces == 1 and file.body.sparse_edges:
        listener.notice(file.body.sparse_edges)
    known = earlier or taken_for_granted(
        baseline(model, file, body), law_is_open(model, file), without, listener.notice
    )
    known.check(body)
    _, recordings = read_recordings(campaign, listener.reading, files)
    recordings = tuple(r.with_middles(pieces) for r in recordings) if pieces else recordings
    try:
        found = diagnose(recordings, known, listener.say, listener.searched, listener.climbed)
        return file, replace(found, changed=changed_trials(recordings, known, found, listener.say)) if apart else found
    except NoPath as none:
        raise InputError(rootless(str(model or campaign), none, known.model.effects)) from none
