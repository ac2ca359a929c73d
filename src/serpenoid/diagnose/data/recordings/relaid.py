"""Clocks laid over each other again, and shapes by the markers of a stretched camera, once it is known what lies
between servos and markers.

At first joints are taken to bend as servos read (clocks.py). Play behind a servo is late in every cycle, and a
displaced marker shows a part of its neighbours' bends: either draws the clock of its trial aside by some milliseconds,
by which the path would then seem to answer to shapes too late or too early.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from serpenoid.diagnose.data.cameras.axes import map_of
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.laid import Laid
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.measure.servo_alignment import seen_corners
from serpenoid.measure.shapes.links import bends, marker_angles

SAME = 3e-5  # of a length: what a scale is told to at best (`resolution` of its effects)


def bent_by(recordings: Sequence[Recording], seen: Observation) -> tuple[tuple[Recording, ...], bool]:
    """Recordings whose shapes, where logs are slow and markers tell the rest, are of the body as it is; whether `seen`
    has another camera than they were by."""
    camera = map_of(seen.axes)
    before = [np.eye(2) if r.camera is None else r.camera for r in recordings if r.slow]
    if all(np.abs(camera - known).max() < SAME for known in before):
        return tuple(recordings), False
    return tuple(replace(r, camera=camera) if r.slow else r for r in recordings), True


def relaid(recordings: Sequence[Recording], seen: Observation) -> tuple[tuple[Recording, ...], bool]:
    """Recordings by the clocks that fit best where markers appear as `seen` has them; whether any of these moved by
    more than its own standard deviation."""
    found = [_late(r, seen) for r in recordings]
    moved = any(abs(late) > sd for late, sd in found)
    return tuple(replace(r, time=r.time + late) for r, (late, _) in zip(recordings, found, strict=True)), moved


def _late(r: Recording, seen: Observation) -> tuple[float, float]:
    """By how much later than its times say a trial was filmed [s], and the standard deviation."""
    markers = seen.unstretched(r.markers)
    corners = seen_corners(r.body, markers)
    begun = seen.begun(r.angles, marker_angles(r.body, markers))
    shown = seen.seen(r.body, seen.angles(r.angles, begun))
    laid = Laid.by(r.time, r.time, bends(markers[:, corners]), r.time, bends(shown[:, corners]), None)
    step, sd = laid.step()
    return float(step[0]), float(sd[0])
