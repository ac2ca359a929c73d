"""What is otherwise than in the reference, without any model: joint angles and paths of the same gaits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.folder import write
from serpenoid.body import Floats
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.windows.tracks import make_tracks
from serpenoid.diagnose.data.windows.windows import Track
from serpenoid.diagnose.report.before import since
from serpenoid.diagnose.since_reference import apart
from serpenoid.diagnose.stages.ladder import Error, Step
from serpenoid.diagnose.start import baseline
from serpenoid.group import compose

AWAY = np.array([0.4, -0.3, 1.1])  # another place and heading
BENT, ALONG_M = 0.07, 0.012


@pytest.fixture(scope="module")
def tracks(tmp_path_factory: pytest.TempPathFactory) -> tuple[Track, ...]:
    """Two gaits, each twice."""
    folder = tmp_path_factory.mktemp("since")
    write(make(64, [], combinations=COMBINATIONS[:2]), folder)
    file, recordings = read_recordings(folder)
    return make_tracks(recordings, Observation.neutral(file.body), baseline(None, file, file.body))


def laid(track: Track, poses: Floats) -> Track:
    return replace(track, measured=poses)


def bent(track: Track, joint: int) -> Track:
    """Its servos read more of a joint."""
    own = track.recording
    assert isinstance(own, Recording)
    more = np.zeros(own.body.joint_count)
    more[joint - 1] = BENT
    return replace(track, recording=replace(own, position=own.position + more))


def once(tracks: Sequence[Track]) -> list[Track]:
    """The first trial of each setting."""
    return list({t.recording.setting: t for t in reversed(tracks)}.values())


def test_the_same_trials_laid_elsewhere_are_not_apart(tracks: tuple[Track, ...]) -> None:
    then = once(tracks)
    found = apart([laid(t, compose(AWAY, t.measured)) for t in then], then)
    assert found is not None
    np.testing.assert_allclose(found["path_m"], 0, atol=1e-12)
    np.testing.assert_allclose(found["joints_rad"], 0, atol=1e-12)
    assert found["repeats_m"] is None
    assert found["joints_repeats_rad"] is None


def test_a_joint_that_reads_more_and_a_path_that_drifts_are_told_by_how_much(tracks: tuple[Track, ...]) -> None:
    """The path of one gait runs ahead evenly from 0 to ALONG_M in the frame of its first pose."""
    first, second = once(tracks)
    seen = np.isfinite(first.measured[:, 0])
    ahead = np.zeros_like(first.measured)
    ahead[seen, 0] = np.linspace(0, ALONG_M, seen.sum())
    start = first.measured[seen][0]
    c, s = np.cos(start[2]), np.sin(start[2])
    drifted = first.measured + np.stack([c * ahead[:, 0], s * ahead[:, 0], 0 * ahead[:, 0]], axis=1)
    found = apart([bent(laid(first, drifted), 3), bent(second, 3)], [first, second])
    assert found is not None
    steps = np.linspace(0, ALONG_M, seen.sum())[1:]
    gaits = {g["gait"]: g["path_m"] for g in found["gaits"]}
    np.testing.assert_allclose(gaits[first.recording.gait], np.sqrt((steps**2).mean()), rtol=1e-9)
    np.testing.assert_allclose(gaits[second.recording.gait], 0, atol=1e-12)
    expected = np.zeros(len(found["joints_rad"]))
    expected[2] = BENT
    np.testing.assert_allclose(found["joints_rad"], expected, atol=2e-3)


def test_chance_is_told_by_repeats_of_the_reference_or_by_those_since(tracks: tuple[Track, ...]) -> None:
    """A change amid the later campaign sets its repeats apart, and is no chance."""
    found, alone = apart(once(tracks), tracks), apart(tracks, once(tracks))
    assert found is not None
    assert alone is not None
    assert found["repeats_m"] == alone["repeats_m"] > 0
    assert found["joints_repeats_rad"] == alone["joints_repeats_rad"]
    amid = apart([tracks[0], bent(tracks[1], 3), *tracks[2:]], tracks)
    assert amid is not None
    assert amid["joints_repeats_rad"] == found["joints_repeats_rad"]
    assert amid["joints_rad"][2] > 5 * amid["joints_repeats_rad"][2]


def test_other_gaits_are_not_compared(tracks: tuple[Track, ...]) -> None:
    one, other = once(tracks)
    assert apart([one], [other]) is None
    assert since({"since_reference": None, "length_unit": "m"}) == []


def test_the_summary_says_what_differs_most(tracks: tuple[Track, ...]) -> None:
    first, second = once(tracks)
    found = apart([bent(first, 3), bent(second, 3)], tracks)
    paths, joints = since({"since_reference": found, "length_unit": "m"})
    assert paths.startswith("without any model, paths differ from it by ")
    assert "(repeats by " in paths
    assert joints.startswith("joint 3 by 4.0")
    assert since({"length_unit": "m"}) == []  # an older answer


def test_the_figure_shows_every_joint_and_setting(tracks: tuple[Track, ...]) -> None:
    from serpenoid.plot.since_reference import since_reference_figure

    found = apart(tracks, tracks)
    assert found is not None
    joints, paths = since_reference_figure(found).axes
    assert len(joints.patches) == 10
    assert len(paths.patches) == 2
    assert [h.get_height() for h in joints.patches] == pytest.approx(np.rad2deg(found["joints_rad"]))
    lone = apart(once(tracks), once(tracks))
    assert lone is not None
    assert not since_reference_figure(lone).axes[1].collections  # nothing was played twice


def test_differences_below_the_noise_level_do_not_fill_the_figure(tracks: tuple[Track, ...]) -> None:
    from serpenoid.plot.since_reference import since_reference_figure

    found = apart(tracks, tracks)
    assert found is not None
    levels = {"actuation": 10 * max(found["joints_rad"]), "motion": 10 * found["path_m"]}
    ladder = [Step("", Error(name, "rad", 0.0, 0.0, level), ()) for name, level in levels.items()]
    joints, paths = since_reference_figure(found, ladder).axes
    assert joints.get_ylim()[1] > np.rad2deg(levels["actuation"])
    assert paths.get_xlim()[1] > 1e3 * levels["motion"]
    plain = since_reference_figure(found).axes[0]
    assert plain.get_ylim()[1] < 0.2 * joints.get_ylim()[1]
