"""Play of a joint whose link lies where load pushes it: what markers show beyond readings takes two values."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.inference.fits.finding import Stage
from serpenoid.diagnose.stages.motion.refuted import shapes_believed
from serpenoid.diagnose.stages.observation.beyond_readings import OfJoint, beyond
from serpenoid.diagnose.stages.observation.play_under_load import crossings, ends_of, play_under_load, two_ends

JOINT = 3  # from 0
WIDTH = 0.11  # rad


def given_way(r, by):
    """The recording as of a servo that reads less than its joint is bent by, by `by` of times and readings."""
    position = r.position.copy()
    position[:, JOINT] -= by(r, r.read_at, position[:, JOINT])
    return replace(r, position=position)


def wave(r, time, shift=1.0):
    return np.sin(2 * np.pi * np.asarray(time) / r.schedule.cycle_duration_s + shift)


def under_load(r, time, read):
    """A link that load pushes from end to end within a twentieth of a cycle; it rests longer at one of them."""
    return WIDTH / 2 * np.clip((wave(r, time) + 0.3) * 6, -1.0, 1.0)


def test_play_under_load_is_named_with_its_width(healthy):
    recordings, _ = healthy
    body = recordings[0].body
    seen = Observation.neutral(body)
    found = play_under_load([beyond(given_way(r, under_load), seen) for r in recordings], [JOINT])
    assert [(n.effect.name, n.effect.place) for n in found] == [("loose_joint", JOINT + 1)]
    (low, high) = found[0].intervals["width"]
    assert low <= WIDTH <= high
    # on its way a ninth of the time, WIDTH / 12^(1/2) from the nearer end (RMS): at most a tenth of WIDTH to a side
    assert WIDTH / 8 < high - low < WIDTH / 5
    assert found[0].strength > 10


def elastic(r, time, read):
    return WIDTH / 2 * wave(r, time)


def slipped(r, time, read):
    """A horn that slips amid the trial, and stays."""
    return np.where(np.asarray(time) > r.end / 2, WIDTH, 0.0)


@pytest.mark.parametrize("by", [elastic, slipped])
def test_what_gives_way_otherwise_is_no_play(healthy, by):
    recordings, _ = healthy
    seen = Observation.neutral(recordings[0].body)
    assert not play_under_load([beyond(given_way(r, by), seen) for r in recordings], [JOINT])


def test_what_is_off_in_proportion_to_the_reading_is_no_play():
    """Of a joint that is told two angles it takes two values, too."""
    time = np.linspace(0, 4, 2000)
    bent = np.clip(6 * np.sin(2 * np.pi * time), -1.0, 1.0)
    noise = np.random.default_rng(3).normal(scale=0.01, size=(2, len(time)))
    frames = np.arange(len(time))
    too_small = OfJoint(0.2 * bent + noise[0], 0.8 * bent + noise[1], frames)
    assert ends_of([too_small, too_small], 0.01) is None
    under_load = OfJoint(0.2 * bent + noise[0], np.sin(2 * np.pi * time + 1.0), frames)
    assert ends_of([under_load, under_load], 0.01) is not None
    assert ends_of([under_load, under_load], 0.5) is None  # below the noise level


def test_a_joint_that_stands_still_may_have_play():
    time = np.linspace(0, 4, 2000)
    pushed = 0.2 * np.clip(6 * np.sin(2 * np.pi * time), -1.0, 1.0)
    trial = OfJoint(pushed, np.full(len(time), 0.3), np.arange(len(time)))
    width, _ = ends_of([trial, trial], 0.01)
    assert width == pytest.approx(0.4, rel=0.02)


def test_a_catalogue_without_play_does_not_name_it(healthy):
    recordings, _ = healthy
    seen = Observation.neutral(recordings[0].body)
    played = [beyond(given_way(r, under_load), seen) for r in recordings]
    assert not play_under_load(played, [JOINT], frozenset({"loose_joint"}))


def test_motion_is_judged_by_the_bend_that_markers_show_and_play_is_named(healthy):
    recordings, known = healthy
    body = recordings[0].body
    squares = [9.0 if j == JOINT else 0.0 for j in range(body.joint_count)]
    stage = Stage("observation", words=("markers do not show it",), squares=(*squares, 1.0))
    given = [given_way(r, under_load) for r in recordings]
    found = shapes_believed(given, Observation.neutral(body), stage, known)
    assert [n.effect.name for n in found.named] == ["loose_joint"]
    assert found.words.startswith(f"motion sides with the markers at joint {JOINT + 1}: ")
    assert found.words.endswith(f"; joint {JOINT + 1} has play, and load decides at which end of its gap the link lies")
    assert all(r.by_markers[JOINT] for r in found.recordings)


def test_two_ends_are_the_means_of_what_lies_about_them():
    values = np.array([0.0, 0.1, -0.1, 1.0, 1.1, 0.9, 1.0])
    assert two_ends(values) == pytest.approx([0.0, 1.0])
    assert crossings(values, np.array([0.0, 1.0])) == 1
    assert crossings(np.array([0.0, 0.5, 0.1, 1.0, 0.6, 0.0]), np.array([0.0, 1.0])) == 2  # amid the gap is no end
