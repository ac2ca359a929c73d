"""Which effects of the medium a recording without repeats shows.

An animal does much the same thing over and over: what fits one part of the recording fits the others too, be it the
cause or not, and significance is cheap. So an effect must also be worth something: take away a good share of what is
left above chance, and all of them together half of the path's error, unless chance is all that they leave.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from serpenoid.diagnose.data.tracked import TrackedRecording, tracker
from serpenoid.diagnose.data.untestable import fixed_to_the_room
from serpenoid.diagnose.inference.held_out import LeaveOut, fitted_again, held_out_error
from serpenoid.diagnose.inference.rules import Unseen
from serpenoid.diagnose.inference.select import Selection
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.choose_motion import MotionFinding, choose_on_tracks, finding

RULE = Unseen(fitted_again, worth=0.2)
HIDDEN = "a body that stood still would leave no more: the points' noise hides what moves it, and nothing can be told"
MAJOR = 0.5  # of the error of the path: all of them together


def choose_tracked(
    recordings: Sequence[TrackedRecording], baseline: Baseline, say: Callable[[str], None]
) -> MotionFinding:
    """Calibrate eps, select effects, name them if they are worth it, say what is left."""
    track = tracker(recordings)
    tracks = track(baseline.model)
    labels = tuple(range(len(tracks)))
    found = choose_on_tracks(track, labels, baseline, say, fixed_to_the_room(tracks), RULE)
    return moving(causes(found, MAJOR, RULE.leave_out))


def moving(found: MotionFinding) -> MotionFinding:
    """The finding; "nothing is missing" is said of a model that leaves less than a body that stands still would."""
    motion, null = found.selection.motion, found.selection.null
    still = np.concatenate([(t.displacement / motion.noise.of(t))[t.usable].ravel() for t in motion.tracks])
    if found.stage.named or not found.stage.settled or null.chi2 + null.evidence.toll(1) < still @ still:
        return found
    return replace(found, stage=replace(found.stage, words=(*found.stage.words, HIDDEN)))


def causes(found: MotionFinding, least: float, leave_out: LeaveOut) -> MotionFinding:
    """The finding; where much is left, and effects take less than a share `least` of the path's error: without them."""
    chosen = found.selection.best.effects
    if not chosen or found.stage.settled:
        return found
    share = explained_share(found.selection, leave_out)
    if share >= least:
        return found
    null = found.selection.null
    bare = finding(replace(found.selection, best=null, bases=(), settled=null, undetected=()))
    names = " and ".join(e.name for e in chosen)
    would = f"would take away {share:.0%} of" if share > 0 else "would add to"
    words = (*bare.stage.words, f"{names} {would} the path's error: too little to be the cause")
    return replace(bare, stage=replace(bare.stage, words=words, untestable=found.stage.untestable))


def explained_share(found: Selection, leave_out: LeaveOut) -> float:
    """Of the path RMS that eps alone leaves on held-out parts, how much the chosen effects take away."""
    before, after = (held_out_error(found.motion, f, leave_out) for f in (found.null, found.best))
    return 1 - after / before
