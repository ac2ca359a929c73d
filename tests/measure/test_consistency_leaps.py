"""Bodies that move by many lengths in a frame."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.measure.consistency.leaps import leap

FRAMES, POINTS = 200, 5
TIME = np.arange(FRAMES) / 50


def swimming(speed: float) -> np.ndarray:
    """A body of one unit that moves by so much in a frame."""
    along = np.linspace(0, 1, POINTS) + speed * np.arange(FRAMES)[:, None]
    return np.stack([along, 0.1 * np.sin(along)], axis=2)


def test_the_first_leap_is_told_with_its_moment_and_size() -> None:
    points = swimming(0.5)
    points[120:] += 1e6
    assert leap(points, TIME) == "leap at 2.4 s by 1.4e+06 body lengths a frame"


def test_what_bodies_do_and_what_hides_them_is_no_leap() -> None:
    assert leap(swimming(2.0), TIME) is None
    carried = swimming(0.0)
    carried[80:130] = np.nan
    carried[130:] += 20.0
    carried[10:20, 2] = np.nan
    assert leap(carried, TIME) is None
    stray = swimming(0.0)
    stray[50, 1] = 1e3  # one marker in one frame is a mistaken match
    assert leap(stray, TIME) is None


@pytest.mark.parametrize("seen", [0, 1])
def test_points_that_are_hardly_seen_say_nothing(seen: int) -> None:
    points = np.full((FRAMES, POINTS, 2), np.nan)
    points[:seen] = 1.0
    assert leap(points, TIME) is None
