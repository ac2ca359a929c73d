"""Trials as the report's animation shows them: measured bodies, and the same shapes where the models would have them.

A model predicts displacements of windows; between their boundaries its distance from the measured path is interpolated.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.noise.paths import gap_steps
from serpenoid.diagnose.data.shapes.geometry import turn
from serpenoid.diagnose.data.windows.windows import Prediction, Track
from serpenoid.group import accumulate, relative
from serpenoid.report.animated import Animated, Layer

if TYPE_CHECKING:
    from serpenoid.diagnose.diagnose import Diagnosis

MEASURED = Layer("measured", "#222222", 16, np.empty(0), np.empty(0))
BASELINE = Layer("baseline, from a fit to the others", "#E69F00", 10, np.empty(0), np.empty(0))
EXTENDED = Layer("extended model, from a fit to the others", "#0072B2", 4, np.empty(0), np.empty(0))


def animated(d: Diagnosis) -> list[Animated]:
    """Every trial, with the predictions of fits to the other gaits."""
    tracks = d.motion.selection.motion.tracks
    jumps = any(n.effect.effect.marks == "jumps" for n in d.named)
    models = {"baseline": (BASELINE, d.held_out[0], False)}
    if d.extension.effects or jumps:
        models["extended"] = (EXTENDED, d.held_out[1], jumps)
    found = []
    for i, track in enumerate(tracks):
        layers = {"measured": _placed(MEASURED, track, track.poses)}
        for name, (layer, p, mend) in models.items():
            layers[name] = _placed(layer, track, predicted(track, p[i], mend))
        name = getattr(track.recording, "name", track.recording.gait)
        same = [t for t in tracks if t.recording is track.recording]
        part = f", part {[t is track for t in same].index(True) + 1}" if len(same) > 1 else ""
        found.append(Animated(name + part, track.time, layers))
    return found


def predicted(track: Track, prediction: Prediction, mend: bool = False) -> Floats:
    """Path (R, 3) of a prediction from the measured first pose, as cameras would show it; a hole in it is bridged by
    what was measured. mend: with the steps that it does not account for across gaps."""
    bounds = track.boundaries
    there = relative(track.poses[bounds[:-1]], track.poses[bounds[1:]])
    steps = np.where(np.isfinite(prediction.displacement), prediction.displacement, there)
    at_bounds = accumulate(steps, track.poses[bounds[0]])
    for first, last, step in gap_steps(track, prediction) if mend else ():
        at_bounds[last:, :2] += turn(track.measured[first, 2], step[:2])
    apart = at_bounds - track.poses[bounds]
    between = [np.interp(track.time, track.time[bounds], c) for c in apart.T]
    return np.asarray(track.poses + np.stack(between, axis=1))


def _placed(layer: Layer, track: Track, poses: Floats) -> Layer:
    length = track.recording.body.total_length_m
    bodies = turn(poses[:, None, 2], track.vertices) + poses[:, None, :2]
    return replace(layer, bodies=bodies / length, path=poses[:, :2] / length)
