"""The ways to take what was commanded: the set-points that servos may have followed.

A log's own word of what servos were told, rows of a table that are joined by lines, or rows that jump; commands that
jump may be goals, each run to until the next is given. A repeat that tells no more of the servos than the trial it
repeats is left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.recordings.recording import ACTED_ON_S, Recording
from serpenoid.diagnose.data.shapes.course import Course
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR
from serpenoid.diagnose.stages.actuation.plays import Plays, played_for_sure
from serpenoid.measure.logs import TICK
from serpenoid.measure.schedule import Schedule

JUMP_S = 1e-6  # before a row is due: a jump takes no time


def ways(recordings: Sequence[Recording], held: bool | None = None) -> Iterator[Plays]:
    """Readings between t0 and the end, at the log's own times, beside the set-points in every way to take them; held:
    whether rows are, where that is known."""
    recordings = _telling(recordings)
    # those that run leave no doubt
    jump = held is not False and not all(r.held_as_told is False for r in recordings)
    if jump and any(r.may_be_goals for r in recordings):
        # commands that jump may be goals of a profile, which runs; rows that run and are as late as a row are that, too
        yield _plays([r.taken(held=False, goals=True) for r in recordings], told=False)
    if not held:
        yield _plays(recordings, told=False)
    if not jump:
        return
    jumping = [r.taken(held=True, goals=False) for r in recordings]
    yield _plays(jumping, told=False)
    if all(r.commands is not None for r in recordings):
        yield _plays(jumping, told=True)


def by_table(recordings: Sequence[Recording], held: bool) -> Plays:
    """All readings beside tables whose rows are held, or run."""
    return _plays([replace(r, schedule=replace(r.schedule, held=held)) for r in recordings], told=False)


def _telling(recordings: Sequence[Recording]) -> list[Recording]:
    """One of each setting, and its repeats in which a joint strays from the command by another amount."""
    found: list[tuple[Recording, Floats, Floats]] = []
    for r in reversed(recordings):
        strays, unsure = _strays(r)
        like = [(s, u) for other, s, u in found if other.setting == r.setting]
        differs = (np.abs(s - strays) > LAW_ERROR**2 * np.maximum(s, strays) + np.maximum(u, unsure) for s, u in like)
        if all(d.any() for d in differs):
            found.append((r, strays, unsure))
    return [r for r, _, _ in reversed(found)]


def _strays(r: Recording) -> tuple[Floats, Floats]:
    """Mean square (m,) of what a trial's readings miss the command by, and how much of it may be its start's. Where
    nothing says when the trial began, it begins where readings meet the command best, and no more is open."""
    time = r.read_at
    inside = (time > 0) & (time < r.promised_s)
    at, read, near = time[inside], r.position[inside], r.unsure_start
    if r.start_said:
        told, late = r.schedule.commanded(at), r.schedule.commanded(at - near)
    else:
        told = late = r.schedule.commanded(at - _course(r).late(at, read, near))
    known = np.isfinite(read)
    often = known.sum(axis=0)
    strays, unsure = (np.where(known, x**2, 0.0).sum(axis=0) / np.maximum(often, 1) for x in (read - told, late - told))
    return strays, np.where(often > 0, unsure + TICK**2, np.inf)


def _course(r: Recording) -> Course:
    """What a trial's table commands."""
    time = np.unique(corners(r.schedule))
    return Course(time, r.schedule.commanded(time))


def _plays(recordings: Sequence[Recording], told: bool) -> Plays:
    readings, labels, times, meshes, setpoints, where = [], [], [], [], [], []
    for number, r in enumerate(recordings):
        time = r.read_at
        inside = played_for_sure(r, told or r.start_said)
        mesh = np.unique(np.concatenate([[0.0], time[inside], *([] if told else [corners(r.schedule), _whenever(r)])]))
        course = Course(time, r.commands) if told and r.commands is not None else None
        setpoints.append(r.schedule.commanded(mesh) if course is None else course.at(mesh))
        times.append(time[inside])
        meshes.append(mesh)
        where.append(np.searchsorted(mesh, time[inside]))
        readings.append(r.position[inside])
        labels.append(np.full(len(readings[-1]), number))
    noise = np.full(recordings[0].body.joint_count, np.inf)
    found = Plays(
        tuple(recordings), np.concatenate(readings), np.concatenate(labels), tuple(times), tuple(meshes),
        tuple(setpoints), tuple(where), noise, told=told,
    )  # fmt: skip
    return found.measured(np.zeros_like(found.readings)).measured(found.realised([]))


def _whenever(r: Recording) -> Floats:
    """Times at which a trial is followed whose beginning its readings tell: they may lie anywhere between two rows."""
    return np.arange(0.0, 0.0 if r.begins_known else r.schedule.whole_s, ACTED_ON_S)


def corners(s: Schedule) -> Floats:
    """Times from 0 on at which rows are due, and just before where they jump."""
    steps = len(s.table)
    corners = [n * s.period_s + np.arange(steps + 1) / steps * s.cycle_duration_s for n in range(s.cycles)]
    jumps = [c - JUMP_S for c in corners] if s.held else []
    every = np.concatenate([*corners, *jumps])
    return np.asarray(every[every >= 0])
