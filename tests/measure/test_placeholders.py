"""An exact point, (0, 0) or another, is `not seen` where a marker leaps there and back, else a place that it passes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from serpenoid.errors import InputError
from serpenoid.measure.film.placeholders import without_placeholders
from serpenoid.measure.load import load_campaign
from serpenoid.measure.tracks import Tracks
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


def lost(points: np.ndarray, share: float, place: tuple[float, float] = (0, 0)) -> tuple[np.ndarray, np.ndarray]:
    """The same with a share of points written as a placeholder, and which."""
    gone = np.random.default_rng(2).random(points.shape[:2]) < share
    return np.where(gone[..., None], place, points), gone


@pytest.mark.parametrize("place", [(0, -0.0), (-1, -1)])
def test_a_film_of_nothing_but_a_placeholder_is_refused_with_it(place: tuple[float, float]) -> None:
    nothing = np.full((FRAMES, POINTS, 2), place)
    said = r"made: every marker is at one point, \((0, 0|-1, -1)\), in every frame. Did the tracker find nothing"
    with pytest.raises(InputError, match=said):
        without_placeholders(tracks(nothing))


@pytest.mark.parametrize("place", [(0, 0), (-1, -1), (-999, 0), (0.5, -0.5)])
@pytest.mark.parametrize("share", [0.002, 0.05, 0.3])
def test_placeholders_to_which_points_leap_are_hidden_and_nothing_else(
    share: float, place: tuple[float, float]
) -> None:
    points, gone = lost(crawl(1e-3), share, place)
    found, said = without_placeholders(tracks(points))
    assert (np.isnan(found.floor[..., 0]) == gone).all()
    assert f"{gone.mean():.1%} of its points are at exactly ({place[0]:g}, {place[1]:g})" in said


def test_a_marker_that_is_lost_once_for_long_is_hidden() -> None:
    points = crawl(1e-3)
    points[100:130, 4] = -1.0
    assert np.isnan(without_placeholders(tracks(points))[0].floor[..., 0]).sum() == 30


@pytest.mark.parametrize("rows", [slice(0, 3), slice(FRAMES - 3, FRAMES)])
@pytest.mark.parametrize("which", [slice(None), slice(0, 4)])
def test_markers_that_are_at_one_point_together_where_a_film_begins_or_ends_are_hidden(
    rows: slice, which: slice
) -> None:
    points = crawl(1e-3)
    points[rows, which] = -1.0
    gone = np.zeros(points.shape[:2], dtype=bool)
    gone[rows, which] = True
    assert (np.isnan(without_placeholders(tracks(points))[0].floor[..., 0]) == gone).all()


@pytest.mark.parametrize("rows", [slice(0, 12), slice(FRAMES - 20, FRAMES)])
def test_a_marker_that_stands_where_a_film_begins_or_ends_while_others_move_is_hidden(rows: slice) -> None:
    points = crawl(1e-3)
    points[rows, 4] = -1.0
    assert np.isnan(without_placeholders(tracks(points))[0].floor[..., 0]).sum() == len(points[rows])


def test_a_point_that_rests_in_the_origin_or_passes_through_it_was_seen() -> None:
    begins = crawl(0.0)
    rests = np.concatenate([np.repeat(begins[:1], 60, axis=0), begins])
    passes = crawl(0.0) - [0.4, 0.0]
    passes[:, 0, 1] = 0.0
    assert (passes[:, 0] == 0).all(axis=1).any()
    for points in (begins, rests, passes, np.round(crawl(1e-3), 2)):
        found, said = without_placeholders(tracks(points))
        assert said == ""
        assert np.isfinite(found.floor).all()


def test_markers_that_are_exchanged_at_rest_hide_nobody() -> None:
    moving = np.round(crawl(1e-3) + 1.0, 2)
    points = np.repeat(moving[:1], FRAMES, axis=0)
    points[120:] = moving[120:]
    for frame in (20, 40, 60):
        points[frame, [3, 5]] = points[frame, [5, 3]]
    assert without_placeholders(tracks(points))[1] == ""


def test_a_single_zero_may_be_anything() -> None:
    for place in (0.0, -1.0):
        points = crawl(1e-3)
        points[100, 4] = place
        assert without_placeholders(tracks(points))[1] == ""


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
