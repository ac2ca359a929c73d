"""Exact (0, 0) is `not seen` where a point leaps there and back, and a place where it rests or passes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from serpenoid.measure.load import load_campaign
from serpenoid.measure.tracks import Tracks
from serpenoid.measure.zeros import without_zeros
from specimens import animal_campaign

FRAMES, POINTS = 240, 9


def crawl(noise: float) -> np.ndarray:
    """Points (F, POINTS, 2) [m] of a body one metre long with a wave on it, which begins with its tail at (0, 0)."""
    time, arc = np.arange(FRAMES)[:, None] / 30, (np.arange(400) + 0.5) / 400
    angle = 0.7 * np.sin(2 * np.pi * (0.5 * time + arc))
    steps = np.stack([np.cos(angle), np.sin(angle)], axis=2) / 400
    points = np.concatenate([np.zeros((FRAMES, 1, 2)), np.cumsum(steps, axis=1)], axis=1)[:, :: 400 // (POINTS - 1)]
    points[..., 0] += 0.1 * time
    return points + np.random.default_rng(1).normal(0, noise, points.shape)


def tracks(points: np.ndarray) -> Tracks:
    names = tuple(f"p{k}" for k in range(points.shape[1]))
    return Tracks(np.arange(len(points)) / 30, names, points, "made", (False,) * len(names))


def lost(points: np.ndarray, share: float) -> tuple[np.ndarray, np.ndarray]:
    """The same with a share of points written as zeros, and which."""
    gone = np.random.default_rng(2).random(points.shape[:2]) < share
    return np.where(gone[..., None], 0.0, points), gone


@pytest.mark.parametrize("share", [0.002, 0.05, 0.3])
def test_zeros_to_which_points_leap_are_hidden_and_nothing_else(share: float) -> None:
    points, gone = lost(crawl(1e-3), share)
    found, said = without_zeros(tracks(points))
    assert (np.isnan(found.floor[..., 0]) == gone).all()
    assert f"{gone.mean():.1%} of its points are at exactly (0, 0)" in said


def test_a_point_that_rests_in_the_origin_or_passes_through_it_was_seen() -> None:
    begins = crawl(0.0)
    rests = np.concatenate([np.repeat(begins[:1], 60, axis=0), begins])
    passes = crawl(0.0) - [0.4, 0.0]
    passes[:, 0, 1] = 0.0
    assert (passes[:, 0] == 0).all(axis=1).any()
    for points in (begins, rests, passes, np.round(crawl(1e-3), 2)):
        found, said = without_zeros(tracks(points))
        assert said == ""
        assert np.isfinite(found.floor).all()


def test_a_single_zero_may_be_anything() -> None:
    points = crawl(1e-3)
    points[100, 4] = 0.0
    assert without_zeros(tracks(points))[1] == ""


def test_a_recording_with_zeros_is_that_with_empty_cells(tmp_path: Path) -> None:
    points, gone = lost(crawl(1e-3), 0.05)
    empty = np.where(gone[..., None], np.nan, points)
    motions = []
    for name, shown in (("zeros", points), ("empty", empty)):
        (tmp_path / name).mkdir()
        (trial,) = load_campaign(animal_campaign(tmp_path / name, name, np.arange(FRAMES) / 30, shown, "m")).trials
        assert any("not seen, and hidden" in note for note in trial.notes) == (name == "zeros")
        motions.append(trial.motion)
    np.testing.assert_array_equal(motions[0].poses, motions[1].poses)
