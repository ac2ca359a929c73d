"""Frames that are in a film twice, to be at another rate, are left out; a body that rests is no such frame."""

import numpy as np
import pytest
from test_filled_in import FRAMES, crawl, tracks

from serpenoid.measure.film.repeated import without_repeated


@pytest.mark.parametrize("scale", [1e4, 500])
@pytest.mark.parametrize(("taken", "shown"), [(15, 30), (12, 30), (24, 30), (8, 30), (25, 50), (15, 25)])
def test_pictures_that_are_there_twice_are_left_out(taken, shown, scale):
    source = np.arange(shown * 8) * taken // shown
    told, said = without_repeated(tracks(np.round(scale * crawl(9, 1e-3, per_second=taken))[source], known=False))
    assert len(told.time_s) == len(np.unique(source))
    assert f"{len(source) - len(told.time_s)} of its {len(source)} frames" in said
    assert np.array_equal(told.time_s, np.flatnonzero(np.diff(source, prepend=-1)) / 30)


@pytest.mark.parametrize("scale", [1e4, 150, 30])
def test_a_film_of_its_own_rate_keeps_its_frames(scale):
    for seed, per_second in enumerate((10, 30, 100, 1000)):
        points = np.round(scale * crawl(9, 1e-3, seed, per_second))
        assert without_repeated(tracks(points, known=False))[1] == ""


def test_a_body_that_rests_is_there_once():
    """It slows down and starts anew, and its pixels stand meanwhile."""
    phase = np.arange(FRAMES) / 12
    at = (12 * (phase - np.sin(2 * np.pi * phase) / (2 * np.pi))).astype(int)  # stands once in twelve frames
    points = np.round(150 * crawl(9, 0.0, per_second=300)[np.minimum(at, FRAMES - 1)])
    assert without_repeated(tracks(points, known=False))[1] == ""


def test_of_two_points_nothing_is_told():
    assert without_repeated(tracks(crawl(9, 1e-3)[np.arange(FRAMES) // 2][:, :2]))[1] == ""
