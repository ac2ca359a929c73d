"""Which effects of the medium a recording without repeats shows.

An animal does much the same thing over and over: what fits one part of the recording fits the others too, be it the
cause or not, and significance is cheap. So an effect must also be worth something: take away a good share of what is
left above chance, and all of them together half of the path's error, unless chance is all that they leave.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from serpenoid.diagnose.baseline import Baseline
from serpenoid.diagnose.choose_motion import MotionFinding, choose_on_tracks, finding
from serpenoid.diagnose.gain import held_out
from serpenoid.diagnose.held_out import Rule, fitted_again
from serpenoid.diagnose.noise import path_error
from serpenoid.diagnose.select import Selection
from serpenoid.diagnose.tracked import TrackedRecording, tracker
from serpenoid.diagnose.untestable import fixed_to_the_room
from serpenoid.model import Model

RULE = Rule(fitted_again, worth=0.2, strict=True)
MAJOR = 0.5  # of the error of the path: all of them together


def choose_tracked(recordings: Sequence[TrackedRecording], model: Model, say: Callable[[str], None]) -> MotionFinding:
    """Calibrate eps, select effects, name them if they are worth it, say what is left."""
    track = tracker(recordings)
    tracks = track(model)
    labels = tuple(range(len(tracks)))
    found = choose_on_tracks(track, labels, Baseline(model), say, fixed_to_the_room(tracks), RULE)
    chosen, share = found.selection.best.effects, explained_share(found.selection)
    if not chosen or found.rung.settled or share >= MAJOR:
        return found
    bare = finding(replace(found.selection, best=found.selection.null, faint=()))
    names = " and ".join(e.name for e in chosen)
    words = (*bare.rung.words, f"{names} would take away {share:.0%} of the path's error: too little to be the cause")
    return replace(bare, rung=replace(bare.rung, words=words, untestable=found.rung.untestable))


def explained_share(found: Selection) -> float:
    """Of the path RMS that eps alone leaves on held-out parts, how much the chosen effects take away."""
    motion = found.motion
    before, after = (path_error(motion, held_out(motion, f, RULE.leave_out)) for f in (found.null, found.best))
    return 1 - after / before
