"""Markers that are off in single frames are hidden; those that stay elsewhere are not, and nothing is lost unsaid."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.folder import write
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.recordings.single_markers import beside_log, told, without_single
from serpenoid.diagnose.stages.observation.choose_observation import choose_observation

SEED, SIZE = 41, 0.03  # m
SHARE = 0.02  # of all markers


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> tuple[Recording, ...]:
    folder = tmp_path_factory.mktemp("healthy")
    write(make(SEED, [], combinations=COMBINATIONS[:1]), folder)
    return read_recordings(folder)[1]


def astray(r: Recording, seed: int = 0) -> tuple[Recording, np.ndarray]:
    """Each marker with one chance in fifty beside its place, and which they are (F, N)."""
    rng = np.random.default_rng(seed)
    off = (rng.random(r.markers.shape[:2]) < SHARE) & np.isfinite(r.markers[..., 0])
    heading = rng.uniform(0, 2 * np.pi, off.shape)
    moved = r.markers + SIZE * off[..., None] * np.stack([np.cos(heading), np.sin(heading)], axis=2)
    return replace(r, markers=moved), off


def test_a_healthy_film_loses_no_marker(recordings: tuple[Recording, ...]) -> None:
    for r in recordings:
        assert r.strays == ()
        assert without_single(r.body, r.time, r.markers)[1] == ()


def test_markers_that_are_off_in_single_frames_are_hidden_and_hardly_any_other(
    recordings: tuple[Recording, ...],
) -> None:
    seen, off = astray(recordings[0])
    kept, strays = without_single(seen.body, seen.time, seen.markers)
    found = beside_log(replace(seen, markers=kept, strays=strays))
    hidden = ~np.isfinite(found.markers[..., 0]) & np.isfinite(seen.markers[..., 0])
    assert (hidden & off).sum() > 0.9 * off.sum()  # of several in one frame not all are told apart
    assert (hidden & ~off).sum() < 0.1 * off.sum()
    assert len(found.strays) >= hidden.sum()
    assert np.median([size for _, size in found.strays]) == pytest.approx(SIZE, rel=0.2)  # a rigid fit follows a little


def test_a_marker_that_stays_elsewhere_is_no_accident_of_a_frame(recordings: tuple[Recording, ...]) -> None:
    r, fallen = recordings[0], recordings[0].markers.copy()
    fallen[len(fallen) * 3 // 4 :, 3] += SIZE
    np.testing.assert_array_equal(without_single(r.body, r.time, fallen)[0], fallen)


def test_what_is_off_now_here_now_there_is_not_passed_over(recordings: tuple[Recording, ...]) -> None:
    stage, _ = choose_observation([astray(r, n)[0] for n, r in enumerate(recordings)],
                                  Observation.neutral(recordings[0].body))  # fmt: skip
    assert not stage.settled


def test_what_markers_were_off_by_in_a_reference_is_no_news(recordings: tuple[Recording, ...]) -> None:
    neutral, seeds = Observation.neutral(recordings[0].body), (0, len(recordings))
    then, now = ([astray(r, seed + n)[0] for n, r in enumerate(recordings)] for seed in seeds)
    before = choose_observation(then, neutral)[0].squares
    assert choose_observation(now, neutral, before=before)[0].settled
    healthy = choose_observation(recordings, neutral)[0].squares
    assert not choose_observation(now, neutral, before=healthy)[0].settled


def test_what_is_said_of_them_counts_and_names_and_sizes() -> None:
    words = told([(2, 0.03), (2, 0.05), (0, 0.04)], 1)
    assert words.startswith("markers are off in single frames 3 times in 1 trial, by 0.04 m (median; up to 0.05 m)")
    assert "vertex 2 (2 times)" in words
