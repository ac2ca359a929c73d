"""Where on the floor a body is: where cameras show it, less what their frame does.

A frame that drifts, or that is another behind a gap, shows a body where it is not, and what lies on the floor stays
where it is. So what a fit knows of the frame is taken out of the places from which a model's steps begin. Displacements
are as they were seen: the fit explains them.

Legend: R rows of a track.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.cameras.frame import of_frame, shifted
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.paths import gap_steps
from serpenoid.diagnose.data.noise.shared import discrepancy
from serpenoid.diagnose.data.shapes.geometry import turn
from serpenoid.diagnose.data.windows.windows import Prediction, Track
from serpenoid.diagnose.inference.fits.jumps import length_of_steps
from serpenoid.diagnose.inference.fits.medium import Fit, candidates_of
from serpenoid.effects.catalogue import marking


def placed(motion: Motion, found: Fit) -> Motion:
    """Tracks with places on the floor as a fit to them knows the cameras' frame."""
    frame, steps = of_frame(found.model.effects), _steps_show(motion, found)
    if not (frame or steps or any(np.any(t.shifted) for t in motion.tracks)):
        return motion
    tracks = []
    for track, p in zip(motion.tracks, found.predictions, strict=True):
        drifted = shifted(frame, track.poses, track.time)
        tracks.append(replace(track, shifted=drifted + (_stepped(track, p) if steps else 0.0)))
    return replace(motion, tracks=tuple(tracks))


def _steps_show(motion: Motion, found: Fit) -> bool:
    """Whether gaps show steps, beside what windows without gaps miss."""
    if all(kind.name in motion.untestable for kind in marking("jumps")):
        return False
    if not any(t.gap_windows.any() for t in motion.tracks):
        return False
    missed = discrepancy(motion, found.predictions)
    return length_of_steps(motion, found.predictions, missed, len(candidates_of(found))) is not None


def _stepped(track: Track, predicted: Prediction) -> Floats:
    """How far steps across gaps have carried a body away from where it is (R, 3) [m, m, rad], unturned; the measured
    path across a gap is a straight line, and so is this."""
    away = np.zeros((len(track.time), 3))
    for first, last, step in gap_steps(track, predicted):
        begin, end = track.boundaries[[first, last]]
        share = np.clip((np.arange(len(away)) - begin) / (end - begin), 0.0, 1.0)
        away[:, :2] += share[:, None] * turn(track.measured[first, 2], step[:2])
    return away
