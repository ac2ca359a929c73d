"""The ladder as a whole: from the command straight to the path, as a simulation without any recording would have it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.diagnose.data.cameras.frame import added, of_frame
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.noise.paths import path_rms, total
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.shapes.geometry import shapes
from serpenoid.diagnose.data.windows.tracks import NoPath, make_tracks
from serpenoid.diagnose.data.windows.windows import Prediction, Track, as_put, predicted_path
from serpenoid.diagnose.stages.actuation.set_points import corners
from serpenoid.diagnose.stages.motion.choose_motion import MotionFinding
from serpenoid.effects.active import ActiveEffect, joined
from serpenoid.group import relative
from serpenoid.measure.schedule import Schedule
from serpenoid.model import Model
from serpenoid.simulation.servos import realise


def whole_errors(
    recordings: Sequence[Recording],
    seen: Observation,
    motion: MotionFinding,
    known: Sequence[ActiveEffect],
    actuators: Sequence[ActiveEffect],
    gone: Sequence[ActiveEffect] = (),
) -> tuple[float, float]:
    """Path RMS [m] of the commanded shapes' motion: baseline against raw data, everything named against mended data.

    known, actuators: effects of the servos that were known, and that are named. gone: those that were there before.
    """
    found = motion.selection
    tracks = found.motion.tracks
    raw = _raw(recordings, found.null.model, tracks) if seen.corrects else tracks
    extended = _with(_with(found.best.model, known), actuators)
    jumps = any(n.effect.effect.marks == "jumps" for n in motion.stage.named)
    played = [r.schedule for r in recordings]
    then = _with(_with(found.null.model, known), gone)
    before = [path_rms(t, from_command(then, t, s)) for t, s in zip(raw, played, strict=True)]
    after = [path_rms(t, from_command(extended, t, s), jumps) for t, s in zip(tracks, played, strict=True)]
    return total(before), total(after)


def _raw(recordings: Sequence[Recording], model: Model, mended: tuple[Track, ...]) -> tuple[Track, ...]:
    """Tracks of what was recorded, nothing mended; the mended ones, where the model has no path along raw shapes."""
    try:
        return make_tracks(recordings, Observation.neutral(recordings[0].body), model)
    except NoPath:
        return mended


def from_command(model: Model, track: Track, schedule: Schedule) -> Prediction:
    """Window displacements of a trial as commanded: set-points, servos, motion from the first measured pose, frame."""
    # set-points are laid on the recording's mesh, so its error is the one that `offset` takes out; jumps take no time
    time = np.unique(np.concatenate([track.time, corners(schedule)])) if schedule.held else track.time
    played = realise(model, schedule.commanded(time), time).angles
    vertices = shapes(model.body, played[np.searchsorted(time, track.time)])
    rows, moved = track.boundaries, np.empty((len(track.playing), 3))
    begun = [0, *(np.flatnonzero(track.put_windows) + 1).tolist()]  # a hand lays it anew
    for first, last in zip(begun, [*begun[1:], len(moved)], strict=True):
        here = slice(rows[first], rows[last] + 1)
        path = predicted_path(model, vertices[here], track.time[here], track.on_floor[rows[first]])
        ends = path[rows[first : last + 1] - rows[first]]
        moved[first:last] = relative(ends[:-1], ends[1:])
    moved += track.offset + track.strayed + added(of_frame(model.effects), track.on_floor[rows], track.time[rows])
    return as_put(track, Prediction(moved, np.zeros((*moved.shape, 0)), ()))


def _with(model: Model, effects: Sequence[ActiveEffect]) -> Model:
    return Model(model.body, model.medium, joined(model.effects, effects))
