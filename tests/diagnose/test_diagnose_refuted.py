"""Where markers refute readings and no effect says why, the motion tells which of the two is wrong."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import serpenoid.diagnose.stages.motion.refuted as refuted_by
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.windows.tracks import NoPath
from serpenoid.diagnose.inference.fits.finding import Stage
from serpenoid.diagnose.stages.motion.refuted import refuted, shapes_believed
from serpenoid.measure.logs import TICK

JOINT = 3  # from 0
OFF = 0.15  # rad: what the joint does beyond what it reads


def said_of(joints: int, which: range) -> Stage:
    """What the stage of observation says where markers refute these joints."""
    squares = [9.0 if j in which else 0.0 for j in range(joints)]
    return Stage("observation", words=("markers do not show it",), squares=(*squares, 1.0))


def swing(r, time, shift):
    return OFF * np.sin(2 * np.pi * np.asarray(time) / r.schedule.cycle_duration_s + shift)


def test_a_joint_that_bends_otherwise_than_it_reads_is_believed_to_bend_as_markers_show_it(healthy):
    recordings, known = healthy
    body = recordings[0].body

    def wrong(r):
        position = r.position.copy()
        position[:, JOINT] += swing(r, r.read_at, 1.0)
        return replace(r, position=position)

    stage = said_of(body.joint_count, range(JOINT, JOINT + 1))
    found = shapes_believed([wrong(r) for r in recordings], Observation.neutral(body), stage, known)
    assert found.words.startswith(f"motion sides with the markers at joint {JOINT + 1}: ")
    for r, true in zip(found.recordings, recordings, strict=True):
        inside = (r.time > 0) & (r.time < r.end)
        off = (r.angles - true.angles)[inside]
        assert np.sqrt((off[:, JOINT] ** 2).mean()) < OFF / 50  # markers' noise, averaged
        assert np.flatnonzero(r.by_markers).tolist() == [JOINT]
        assert np.abs(np.delete(off, JOINT, axis=1)).max() < TICK / 100  # of other joints readings alone count


def test_where_a_marker_moves_on_the_body_readings_are_believed(healthy):
    recordings, known = healthy
    body = recordings[0].body
    vertex = body.joint_vertices[JOINT]

    def moved(r):
        markers = r.markers.copy()
        markers[:, vertex, 1] += 0.1 * swing(r, r.time, 0.0)
        return replace(r, markers=markers)

    stage = said_of(body.joint_count, range(JOINT - 1, JOINT + 2))
    found = shapes_believed([moved(r) for r in recordings], Observation.neutral(body), stage, known)
    assert all(r.shown is None for r in found.recordings)


def test_what_is_named_is_no_refutation(healthy):
    recordings, known = healthy
    body = recordings[0].body
    settled = replace(said_of(body.joint_count, range(JOINT, JOINT + 1)), words=())
    assert refuted(settled, body.joint_count) == []
    assert refuted(Stage("observation", words=("frames are off",), squares=(1.5,) * 20), body.joint_count) == []
    found = shapes_believed(recordings, Observation.neutral(body), settled, known)
    assert not found.words
    assert all(a is b for a, b in zip(found.recordings, recordings, strict=True))


def test_what_markers_never_show_they_do_not_refute(healthy):
    recordings, known = healthy
    body = recordings[0].body

    def hidden(r):
        markers = r.markers.copy()
        markers[:, body.joint_vertices[JOINT]] = np.nan
        return replace(r, markers=markers)

    stage = said_of(body.joint_count, range(JOINT, JOINT + 1))
    found = shapes_believed([hidden(r) for r in recordings], Observation.neutral(body), stage, known)
    assert not found.words


SAID = {
    (0.9, 1.0): "",
    (
        1.0,
        0.9,
    ): "motion is judged by the bend that markers show at joint 4: a window is off by 900 mm by what markers show",
    (0.5, 1.0): "motion sides with the readings at joint 4: .*; look for markers there that move",
    (1.0, 0.5): "motion sides with the markers at joint 4: .*; look for what gives way",
}


@pytest.mark.parametrize("misses", SAID)
def test_nobody_is_blamed_where_both_miss_nearly_as_much(healthy, monkeypatch, misses):
    recordings, known = healthy
    by_readings, by_shown = misses
    left = {True: by_readings, False: by_shown}
    monkeypatch.setattr(refuted_by, "missed", lambda by, _: left[by.recordings[0].shown is None])
    body = recordings[0].body
    stage = said_of(body.joint_count, range(JOINT, JOINT + 1))
    found = shapes_believed(recordings, Observation.neutral(body), stage, known)
    assert re.match(SAID[misses], found.words)
    assert bool(found.words) == bool(SAID[misses])
    assert (found.recordings[0].shown is None) == (by_readings < by_shown)


@pytest.mark.parametrize("others", [0, 1])
def test_a_model_without_a_path_along_one_of_both_is_no_witness(healthy, monkeypatch, others):
    """The next explanation of what was so already is asked; where there is none, nobody is believed."""
    recordings, known = healthy

    class Left:
        def __init__(self, more: int) -> None:
            self.more = more

        def instead(self, trial: str) -> Left | None:
            assert trial == recordings[0].name
            return Left(self.more - 1) if self.more else None

    def missed(by, baseline):
        found = 1.0 if by.recordings[0].shown is None else 0.5
        if baseline.more == others and found < 1:
            raise NoPath(recordings[0].name)
        return found

    monkeypatch.setattr(refuted_by, "missed", missed)
    body = recordings[0].body
    stage = said_of(body.joint_count, range(JOINT, JOINT + 1))
    left = Left(others)
    left.without = known.without
    found = shapes_believed(recordings, Observation.neutral(body), stage, left)
    assert found.words.startswith("motion sides with the markers at joint 4" if others else "")
    assert bool(found.words) == bool(others)
    assert (found.recordings[0].shown is None) == (not others)
