"""A picture that shows one direction, or one place, larger than another is told; one that shows all alike is not."""

import re

import numpy as np
import pytest

from serpenoid.measure.load import load_campaign
from specimens import animal_campaign
from swimmers_by_curves import Curve

TURNED = np.array([[0.8, 0.6], [-0.6, 0.8]])


def film(points: int = 11, noise: float = 0.002, amplitude: float = 0.8) -> tuple[np.ndarray, np.ndarray]:
    """Times (F,) and points (F, N, 2) of a body one unit long, as a picture shows them that shows all alike."""
    beats, body, _ = Curve(ratio=5.0, waves=1.2, amplitude=amplitude).film(points, 181, 6)
    return beats, body @ TURNED + np.random.default_rng(3).normal(0, noise, body.shape)


def notes(folder, time, points) -> str:
    return " ".join(load_campaign(animal_campaign(folder, "a", time, points, "m")).trials[0].notes)


@pytest.mark.parametrize(("ratio", "long", "short"), [(1.03, "x", "y"), (1 / 1.05, "y", "x")])
def test_pixels_that_are_not_square_are_told_with_what_mends_them(tmp_path, ratio, long, short):
    time, points = film()
    said = notes(tmp_path, time, points * [ratio, 1])
    found = re.search(r"longer where they point along (\w) than .* multiply (\w) by ([\d.]+) in the file", said)
    assert found
    assert found.groups()[:2] == (long, short)
    assert float(found[3]) == pytest.approx(max(ratio, 1 / ratio), abs=0.005)
    assert "peristalsis" not in said


def test_a_camera_that_looks_aslant_is_told(tmp_path):
    """At a point on an axis between x and y: across it lengths are cos(15 degrees) of what they are along it."""
    time, points = film()
    turn = np.array([[1.0, -1.0], [1.0, 1.0]]) / np.sqrt(2)
    said = notes(tmp_path, time, points @ turn.T * [1, np.cos(np.radians(15))] @ turn)
    found = re.search(r"([\d.]+)% longer where they point along a line at (-?\d+) degrees", said)
    assert found
    assert float(found[1]) == pytest.approx(3.5, abs=0.7)
    assert float(found[2]) == pytest.approx(-45, abs=5)


def test_a_picture_that_is_larger_at_one_place_is_told(tmp_path):
    time, points = film()
    away = points[..., :1] - points[..., :1].mean()
    assert "longer at one place of the picture" in notes(tmp_path, time, points * (1 + 0.05 * away))


@pytest.mark.parametrize(("points", "noise", "amplitude"), [(11, 0.002, 0.8), (8, 0.01, 1.1), (21, 0.004, 0.4)])
def test_a_picture_that_shows_all_alike_is_not_accused(tmp_path, points, noise, amplitude):
    said = notes(tmp_path, *film(points, noise, amplitude))
    assert "where they point" not in said
    assert "place of the picture" not in said


def test_straight_links_do_not_shorten_as_they_bend_which_is_no_picture(tmp_path):
    time = np.arange(100) / 20
    angle = 0.5 * np.sin(2 * np.pi * (time[:, None] + np.arange(6) / 7))
    steps = np.stack([np.cos(angle), np.sin(angle)], axis=2) / 6
    points = np.concatenate([np.zeros((100, 1, 2)), np.cumsum(steps, axis=1)], axis=1)
    points = points - points.mean(axis=1, keepdims=True) + 0.3 * time[:, None, None] * np.array([1.0, 0.0])
    points += np.random.default_rng(0).normal(0, 1e-3, points.shape)
    assert "where they point" not in notes(tmp_path, time, points)
