"""What servos are expected to do with what is known of them, and recordings that carry it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.recordings.recording import ACTED_ON_S, Recording
from serpenoid.diagnose.data.shapes.course import Course
from serpenoid.diagnose.stages.actuation.plays import Plays, came_from, played_for_sure
from serpenoid.diagnose.stages.actuation.set_points import corners
from serpenoid.effects.active import ActiveEffect
from serpenoid.simulation.servos import coordinates, late_by, realise_all

WITHIN_ROW = 4  # steps in which servos are followed from row to row


def carried(recordings: Sequence[Recording], found: Plays, effects: Sequence[ActiveEffect]) -> tuple[Recording, ...]:
    """Recordings with what their servos are expected to do: their shapes are splines about it. Where no label says when
    a trial began, it begins where that is met best: not where a joint that lags made it seem to. So it does where rows
    are held, within what is left open: a slow log says of a jump only that it was between two readings."""
    return tuple(_begun(r, late, course) for r, late, course in _met(recordings, found, effects))


def expected(recordings: Sequence[Recording], found: Plays, effects: Sequence[ActiveEffect]) -> tuple[Course, ...]:
    """What servos are expected to do, trial by trial, with these effects beside the known ones."""
    met = zip(recordings, _met(recordings, found, effects), strict=True)
    return tuple(_moved(course, late + r.due_later(found.goals)) for r, (_, late, course) in met)


def _moved(course: Course, late: float) -> Course:
    """So much later [s]: times that differ by rounding alone may be one then."""
    time, first = np.unique(course.time + late, return_index=True)
    return Course(time, course.angles[first])


def _met(
    recordings: Sequence[Recording], found: Plays, effects: Sequence[ActiveEffect]
) -> list[tuple[Recording, float, Course]]:
    """Recordings, how late their trials began [s] as far as that is open, and what servos do from there on."""
    recordings = [r.taken(found.held, found.goals) for r in recordings]
    model = found.model(effects)
    between = [_between(r) if model.actuation_effects else np.zeros(1) for r in recordings]  # known ones among them
    late = late_by(coordinates(model))  # corners are then, too
    meshes = [
        np.unique(np.concatenate([corners(r.schedule) + late, t])) for r, t in zip(recordings, between, strict=True)
    ]
    told = [r.schedule.commanded(t) for r, t in zip(recordings, meshes, strict=True)]
    rested = [came_from(r, t) for r, t in zip(recordings, told, strict=True)]
    played = realise_all(model, told, meshes, came_from=rested)
    courses = [Course(time, p.readings) for time, p in zip(meshes, played, strict=True)]
    return [(r, 0.0 if r.begins_known else _late(r, c), c) for r, c in zip(recordings, courses, strict=True)]


def _late(r: Recording, course: Course) -> float:
    """How late [s] a trial's readings meet what servos do best."""
    inside = played_for_sure(r, begun=False) & (r.read_at < r.end)
    return course.late(r.read_at[inside], r.position[inside], r.unsure_start, r.schedule.jumps_every_s)


def _begun(r: Recording, late: float, course: Course) -> Recording:
    """A recording whose time counts from where its trial began, on both clocks, and what servos do from there on."""
    return replace(r, time=r.time - late, log_time=r.log_time - late * (1 + r.clock.rate), carrier=course)


def _between(r: Recording) -> Floats:
    """Times from 0 on, some in each row, at which servos are followed, in pauses and to the log's end as well: after a
    jump they are through with it long before the next."""
    apart = r.schedule.row_s / WITHIN_ROW
    apart = min(apart, ACTED_ON_S) if r.schedule.held else apart
    return np.asarray(apart * np.arange(max(r.read_at[-1], r.end) / apart + 1))
