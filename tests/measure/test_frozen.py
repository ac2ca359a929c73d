"""Markers that stand while the others move are told; a robot at rest, or one that turns about a point, is not;
and a film that hangs."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.measure.consistency.frozen import frozen, frozen_said, hung, hung_said
from serpenoid.measure.load import load_campaign
from specimens import animal_campaign

FRAMES = 100


def moving(digits: int) -> np.ndarray:
    """Five points (F, 5, 2) [m] that run along and sway, as a file with so many digits has them."""
    time = np.arange(FRAMES)[:, None] / 25
    x = 0.1 * np.arange(5) + 0.05 * time
    y = 0.02 * np.sin(2 * np.pi * (time + np.arange(5) / 5))
    return np.round(np.stack([x, y], axis=2), digits)


@pytest.mark.parametrize("place", [(0.0, 0.0), (0.2, 0.3)])
def test_a_point_that_stands_for_a_while_is_told_with_its_name(place):
    points = moving(5)
    points[30:60, 2] = place
    counts = frozen(points)
    assert counts.tolist() == [0, 0, 30, 0, 0]
    assert "`mid` in 30 frames" in frozen_said(counts, ["a", "b", "mid", "c", "d"])


def test_a_body_at_rest_or_turning_about_a_point_has_no_frozen_markers():
    rest = moving(4)
    rest[40:70] = rest[40]
    assert not frozen(rest).any()
    time = 1e-4 * np.arange(FRAMES)[:, None]  # rad a frame: 1 to 4 steps of the file in ten frames
    reach = np.arange(5)
    turning = np.round(np.stack([reach * np.cos(time), reach * np.sin(time)], axis=2), 3)
    assert not frozen(turning[:20]).any()
    assert not frozen(moving(3)).any()
    assert frozen_said(frozen(rest), list("abcde")) is None


def test_hidden_points_do_not_stand():
    points = moving(5)
    points[20:50, 1] = np.nan
    assert not frozen(points).any()


@pytest.mark.parametrize("hidden", [None, slice(0, FRAMES), slice(30, 40), slice(35, FRAMES)])
@pytest.mark.parametrize("frames", [4, 20])
def test_a_film_that_hangs_is_told_whichever_point_it_misses(hidden, frames):
    points = moving(5)
    points[30 : 30 + frames] = points[30]
    if hidden is not None:
        points[hidden, 2] = np.nan
    assert hung(points) == [(30, 29 + frames)]
    assert "from 1.2 to " in hung_said(hung(points), np.arange(FRAMES) / 25)


def test_a_body_that_rests_and_goes_on_or_is_filmed_coarsely_does_not_hang():
    points = moving(5)
    rest = np.concatenate([points[:30], np.repeat(points[30:31], 20, axis=0), points[30:]])
    every_frame_twice = np.repeat(points, 2, axis=0)
    coarse = moving(2)  # the file's step is what the body goes in five frames
    begins, ends = np.repeat(points[:1], 20, axis=0), np.repeat(points[-1:], 20, axis=0)
    for film in (points, rest, every_frame_twice, coarse, np.concatenate([begins, points, ends]), points * np.nan):
        assert hung(film) == []
    assert hung_said([], np.arange(FRAMES) / 25) is None


def test_it_is_said_of_the_trial(tmp_path):
    points = moving(9) + np.random.default_rng(0).normal(0, 2e-4, (FRAMES, 5, 2))
    points[30:60, 2] = points[30, 2]
    (trial,) = load_campaign(animal_campaign(tmp_path, "crawler", np.arange(FRAMES) / 25, points, "m")).trials
    assert any("stand still while the others move" in note for note in trial.notes)
    points[60:75, 2], points[60:75] = np.nan, points[60]
    (trial,) = load_campaign(animal_campaign(tmp_path, "crawler", np.arange(FRAMES) / 25, points, "m")).trials
    assert any("from 2.4 to 2.96 s no point moves in any digit" in note for note in trial.notes)
