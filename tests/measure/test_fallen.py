"""A marker that fell off lies where it is while the body goes on; one that rests with its body did not fall."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.measure.consistency.fallen import fallen

EDGES = np.array([0.06, 0.09, 0.07, 0.11, 0.08, 0.05])
TIME = np.arange(400) / 50


def film(seed: int, noise: float, rests_from: int = 400) -> np.ndarray:
    """A snake that goes on by a body length, and may come to rest (F, N, 2)."""
    at = np.minimum(TIME, TIME[min(rests_from, 399)])[:, None]
    turned = 0.7 * np.sin(2 * np.pi * (at / 2 - np.arange(len(EDGES)) / 6))
    steps = EDGES[:, None] * np.stack([np.cos(turned), np.sin(turned)], axis=2)
    points = np.concatenate([np.zeros((len(TIME), 1, 2)), np.cumsum(steps, axis=1)], axis=1)
    points += np.stack([0.06 * at, 0.02 * at], axis=2)
    return points + np.random.default_rng(seed).normal(0, noise, points.shape)


@pytest.mark.parametrize("noise", [0.0002, 0.002])
@pytest.mark.parametrize("marker", [0, 2, 6])
def test_a_marker_that_fell_off_is_told_with_the_moment(marker, noise):
    points = film(marker, noise)
    lies = np.random.default_rng(9).normal(0, noise, (200, 2)) + points[200, marker]
    points[200:, marker] = lies
    points[50:60, 4] = np.nan
    (found,) = fallen(points)
    assert found.marker == marker
    assert TIME[found.frame] == pytest.approx(TIME[200], abs=0.3)  # it was slow before
    assert "did it" not in found.words("tail", TIME)


@pytest.mark.parametrize("rests_from", [100, 300, 400])
@pytest.mark.parametrize("noise", [0.0002, 0.003])
def test_none_fell_off_a_body_that_comes_to_rest(rests_from, noise):
    points = film(1, noise, rests_from)
    points[350:, 5] = np.nan  # hidden, not fallen
    assert fallen(points) == ()


def test_a_marker_beside_its_place_did_not_fall():
    points = film(2, 0.0005)
    points[:, 3] += 0.02
    assert fallen(points) == ()
