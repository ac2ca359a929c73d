"""What servos are expected to do with what is known of them, and recordings that carry it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.course import Course
from serpenoid.diagnose.data.recording import Recording
from serpenoid.diagnose.stages.plays import Plays, unsure_start
from serpenoid.diagnose.stages.set_points import corners
from serpenoid.effects.active import ActiveEffect
from serpenoid.simulation.servos import realise_all

WITHIN_ROW = 4  # steps in which servos are followed from row to row


def carried(recordings: Sequence[Recording], found: Plays, effects: Sequence[ActiveEffect]) -> tuple[Recording, ...]:
    """Recordings with what their servos are expected to do: their shapes are splines about it."""
    recordings = [replace(r, schedule=replace(r.schedule, held=found.held)) for r in recordings]
    pairs = zip(recordings, expected(recordings, found, effects), strict=True)
    return tuple(replace(r, carrier=course) for r, course in pairs)


def expected(recordings: Sequence[Recording], found: Plays, effects: Sequence[ActiveEffect]) -> tuple[Course, ...]:
    """What servos are expected to do, trial by trial, with these effects beside the known ones."""
    recordings = [replace(r, schedule=replace(r.schedule, held=found.held)) for r in recordings]
    meshes = [np.unique(np.concatenate([corners(r), _between(r) if effects else [0.0]])) for r in recordings]
    told = [r.schedule.commanded(t) for r, t in zip(recordings, meshes, strict=True)]
    played = realise_all(found.model(effects), told, meshes)
    courses = [Course(time, p.readings) for time, p in zip(meshes, played, strict=True)]
    return tuple(c if r.start_said else _begun(r, c) for r, c in zip(recordings, courses, strict=True))


def _begun(r: Recording, course: Course) -> Course:
    """A course from where a trial's readings meet it best."""
    inside = (r.read_at > 0) & (r.read_at < r.end)
    late = course.late(r.read_at[inside], r.position[inside], unsure_start(r))
    return Course(course.time + late, course.angles)


def _between(r: Recording) -> Floats:
    """Times from 0 on, some in each row, at which servos are followed, in pauses and to the log's end as well."""
    apart = r.schedule.cycle_duration_s / len(r.schedule.table) / WITHIN_ROW
    return np.asarray(apart * np.arange(max(r.read_at[-1], r.end) / apart + 1))
