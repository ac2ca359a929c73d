"""Which effects of the medium a recording without repeats shows.

An animal does much the same thing over and over: what fits one part of the recording fits the others too, be it the
cause or not. Like a robot's gaits, the parts tell by how far they disagree what is a cause; and all that is named must
take away more than it leaves.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.data.tracked import TrackedRecording, tracker
from serpenoid.diagnose.data.untestable import fixed_to_the_room
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.choose_motion import MotionFinding, Searched, choose_on_tracks

GLIDES = (
    "a body that only glides on, whatever it bends, would leave no more: nothing can be told of what moves this one"
)
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
    """The finding; where a model leaves no less than a body that stands still would, or what is named no less than one
    that glides through each part at one velocity, that is said, and names may stand in for what moves it."""
    motion, null, best = found.selection.motion, found.selection.null, found.selection.best
    still, gliding, velocities = _without_forces(motion)
    if not found.stage.named:
        idle = null.chi2 + null.evidence.toll(1) >= still
        return _doubted(found, STILL) if idle else found
    idle = best.chi2 + best.evidence.toll(len(best.coordinates)) >= gliding + best.evidence.toll(velocities)
    return _doubted(found, GLIDES) if idle else found


def _doubted(found: MotionFinding, why: str) -> MotionFinding:
    named = tuple(replace(n, stand_in=True) for n in found.stage.named)
    return replace(found, stage=replace(found.stage, named=named, words=(*found.stage.words, why)))


def _without_forces(motion: Motion) -> tuple[float, float, int]:
    """Chi squared of a body that stands still, that of one that keeps the velocity of each part which leaves least,
    and how many numbers these velocities are."""
    still, gliding = 0.0, 0.0
    for t in motion.tracks:
        z = (t.displacement / motion.noise.of(t))[t.usable]
        by = (t.duration[:, None] / motion.noise.of(t))[t.usable]
        still += float((z**2).sum())
        gliding += float((z**2).sum() - ((z * by).sum(axis=0) ** 2 / (by**2).sum(axis=0)).sum())
    return still, gliding, 3 * len(motion.tracks)
