"""What changed amid a campaign: trials in which something acts, diagnosed beside those in which it does not.

Which trials these are a stage of the diagnosis of all has told (`Stage.divided`). Beside an earlier campaign that is
the reference; without one, the side of the trials that needs fewer causes is, if some gait was played on both sides:
else it may be the gaits that differ, unless no gait makes what divides them, as of clocks.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.windows.tracks import NoPath
from serpenoid.diagnose.diagnose import Diagnosis, diagnose
from serpenoid.diagnose.inference.fits.finding import Divided, Named, Stage
from serpenoid.diagnose.reference import reference_of
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.motion.values_of_motion import beside_known


@dataclass(frozen=True)
class ChangedTrials:
    """divided: how trials are; found: of those in which something acts; before: of the others, if they are what these
    are held against."""

    divided: Divided
    found: Diagnosis
    before: Diagnosis | None


def changed_trials(
    recordings: Sequence[Recording], known: Baseline, whole: Diagnosis, say: Callable[[str], None]
) -> ChangedTrials | None:
    """What changed, where the diagnosis of all (`whole`) tells that trials are divided; None where it does not, where
    one of the two has no path, and where trials that are perhaps divided are not explained alone. known: what all were
    held against."""
    if whole.divided is None:
        return None
    changed, others = sides(recordings, whole.divided)
    played = [{r.setting for r in side} for side in (changed, others)]
    if known.ratio is None and not whole.divided.any_gait and not played[0] & played[1]:
        return None
    try:
        before = None
        if known.ratio is None:
            before, changed, others = _as_it_was(changed, others, known, say)
            known = reference_of(before)
        found = diagnose(changed, known, say)
    except NoPath:
        return None
    divided = replace(whole.divided, changed=tuple(r.name for r in changed), others=tuple(r.name for r in others))
    found = beside_growth(found, divided.grows)
    return None if divided.perhaps and found.verdict != "explained" else ChangedTrials(divided, found, before)


def beside_growth(found: Diagnosis, grows: float) -> Diagnosis:
    """What is found of trials in each of which a cause may be of another size (`Divided.grows`)."""
    motion, change = next(s for s in found.stages if s.name == "motion"), found.ratio_change
    does = [n.strength for n in motion.named if n.effect.effect.moves] + ([change.strength] if change else [])
    beside = mending_growth(motion, grows * max(does, default=0.0))
    beside = replace(beside, named=tuple(in_any_trial(n, grows) for n in beside.named))
    return replace(found, stages=tuple(beside if s is motion else s for s in found.stages), grows=grows)


def in_any_trial(named: Named, grows: float) -> Named:
    """A cause of the floor, its intervals over what it may be in each of the trials: all are within a share of their
    mean to either side, and what is told may be that of any."""
    law = named.effect.effect
    if not law.moves or not grows:
        return named
    ends = np.array([(1 - grows) / (1 + grows), (1 + grows) / (1 - grows) if grows < 1 else np.inf]) - 1
    sizes = [
        0.0 if p.neutral is None else x - p.coordinate(named.before.get(p.name, p.neutral))
        for p, x in zip(law.parameters, named.effect.coordinates, strict=False)
    ]
    return beside_known(named, np.array([np.sort(size * ends) if size else (0.0, 0.0) for size in sizes]))


def mending_growth(stage: Stage, most: float) -> Stage:
    """Names of the floor that do no more than so much, over the noise, may mend what one size of the largest leaves of
    trials in which it differs by that: stand-ins, and no names where they may change nothing."""
    every = [replace(n, stand_in=n.stand_in or (n.effect.effect.moves and n.strength <= most)) for n in stage.named]
    return stage.naming(every)


def _as_it_was(
    changed: list[Recording], others: list[Recording], known: Baseline, say: Callable[[str], None]
) -> tuple[Diagnosis, list[Recording], list[Recording]]:
    """The diagnosis of the side in which nothing acts, the other side, and itself. A first guess may have exchanged the
    two: then something is named in `others`, and nothing in the ones that changed."""
    before = diagnose(others, known, say)
    if before.named and not (after := diagnose(changed, known, say)).named:
        return after, others, changed
    return before, changed, others


def sides(recordings: Sequence[Recording], divided: Divided) -> tuple[list[Recording], list[Recording]]:
    """Recordings in which it acts, and others. One of which nothing is told, as its servos did as those of another
    repeat, is on the side of its setting; on neither if its setting is on both."""
    told = dict.fromkeys(divided.changed, True) | dict.fromkeys(divided.others, False)
    by_setting: dict[tuple[str, float], set[bool]] = {}
    for r in recordings:
        if r.name in told:
            by_setting.setdefault(r.setting, set()).add(told[r.name])
    side = {r.name: {told[r.name]} if r.name in told else by_setting.get(r.setting, set()) for r in recordings}
    changed, others = ([r for r in recordings if side[r.name] == {acts}] for acts in (True, False))
    return changed, others
