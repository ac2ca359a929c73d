"""Which effects of the medium a recording without repeats shows.

An animal does much the same thing over and over: what fits one part of the recording fits the others too, be it the
cause or not. Like a robot's gaits, the parts tell by how far they disagree what is a cause; and all that is named must
take away more than it leaves.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from serpenoid.diagnose.data.tracked import TrackedRecording, tracker
from serpenoid.diagnose.data.untestable import fixed_to_the_room
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.choose_motion import MotionFinding, Searched, choose_on_tracks

STILL = "a body that stood still would leave no more: nothing can be told of what moves this one, nor of its eps"


def choose_tracked(
    recordings: Sequence[TrackedRecording],
    baseline: Baseline,
    say: Callable[[str], None],
    searched: Searched = lambda found: None,
) -> MotionFinding:
    """Calibrate eps, select effects, name them if they are worth it, say what is left."""
    track = tracker(recordings)
    tracks = track(baseline.model)
    labels = tuple(range(len(tracks)))
    found = choose_on_tracks(track, labels, baseline, say, fixed_to_the_room(tracks), searched=searched)
    return moving(found)


def moving(found: MotionFinding) -> MotionFinding:
    """The finding; where a model leaves no less than a body that stands still would, that is said."""
    motion, null = found.selection.motion, found.selection.null
    still = np.concatenate([(t.displacement / motion.noise.of(t))[t.usable].ravel() for t in motion.tracks])
    if found.stage.named or null.chi2 + null.evidence.toll(1) < still @ still:
        return found
    return replace(found, stage=replace(found.stage, words=(*found.stage.words, STILL)))
