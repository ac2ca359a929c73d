"""Which effects of the medium a recording without repeats shows.

An animal does much the same thing over and over: what fits one part of the recording fits the others too, be it the
cause or not, and significance is cheap. So an effect must also be worth something: take away a good share of what is
left above chance, and all of them together half of the path's error, unless chance is all that they leave.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from serpenoid.diagnose.data.tracked import TrackedRecording, tracker
from serpenoid.diagnose.data.untestable import fixed_to_the_room
from serpenoid.diagnose.inference.held_out import fitted_again
from serpenoid.diagnose.inference.rules import Unseen
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.choose_motion import MotionFinding, causes, choose_on_tracks

RULE = Unseen(fitted_again, worth=0.2)
MAJOR = 0.5  # of the error of the path: all of them together


def choose_tracked(
    recordings: Sequence[TrackedRecording], baseline: Baseline, say: Callable[[str], None]
) -> MotionFinding:
    """Calibrate eps, select effects, name them if they are worth it, say what is left."""
    track = tracker(recordings)
    tracks = track(baseline.model)
    labels = tuple(range(len(tracks)))
    found = choose_on_tracks(track, labels, baseline, say, fixed_to_the_room(tracks), RULE)
    return causes(found, MAJOR, RULE.leave_out)
