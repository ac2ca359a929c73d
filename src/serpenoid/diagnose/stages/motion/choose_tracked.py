"""Which effects of the medium a recording without repeats shows.

An animal does much the same thing over and over: what fits one part of the recording fits the others too, be it the
cause or not. Like a robot's gaits, the parts tell by how far they disagree what is a cause; and all that is named must
take away more than it leaves.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.tracked import TrackedRecording, tracker
from serpenoid.diagnose.data.untestable import fixed_to_the_room
from serpenoid.diagnose.data.windows.windows import Track
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.motion.choose_motion import MotionFinding, Searched, choose_on_tracks
from serpenoid.measure.animals.beside_midline import beside_midline
from serpenoid.measure.shapes.links import bends
from serpenoid.wording import OF_SHAPES

GLIDES = (
    "a body that only glides on, whatever it bends, would leave no more: nothing can be told of what moves this one"
)
ASIDE = "a point stands beside the body's midline"
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
    return off_midline(moving(found), tracks)


def off_midline(found: MotionFinding, tracks: Sequence[Track]) -> MotionFinding:
    """The finding; where a point stands beside the body's midline, shapes are wrong there, and names may stand in for
    that."""
    body = tracks[0].recording.body
    if not found.stage.named or not body.is_animal:
        return found
    aside = beside_midline(body.edges, np.concatenate([bends(t.vertices) for t in tracks]))
    if aside is None:
        return found
    return _doubted(found, f"{ASIDE} (point {aside.vertex + 1} from the tail): {OF_SHAPES}")


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
    for t, white in zip(motion.tracks, motion.white, strict=True):
        z = white.of(t.displacement, t.usable).reshape(-1, 3)
        by = white.of(np.broadcast_to(t.duration[:, None], t.displacement.shape), t.usable).reshape(-1, 3)
        still += float((z**2).sum())
        gliding += float((z**2).sum() - ((z * by).sum(axis=0) ** 2 / (by**2).sum(axis=0)).sum())
    return still, gliding, 3 * len(motion.tracks)
