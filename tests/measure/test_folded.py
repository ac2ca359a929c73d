"""A body that is folded back all the time is one whose points are named in another order."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.measure.animals.folded import folded

LENGTH = np.linspace(0.0, 1.0, 9)


def worm(amplitude: float, frames: int = 60) -> np.ndarray:
    """Points of a wave that runs along a body, bends by so many radians a length."""
    time = np.arange(frames)[:, None] / 20
    heading = amplitude * np.cos(2 * np.pi * (time - 1.3 * LENGTH[:-1]))
    steps = np.stack([np.cos(heading), np.sin(heading)], axis=2) / (len(LENGTH) - 1)
    return np.concatenate([np.zeros((frames, 1, 2)), np.cumsum(steps, axis=1)], axis=1)


@pytest.mark.parametrize("order", [[4, 8, 0], [0, 1, 2, 3, 4, 6, 7, 8, 5], [8, 0, 4]])
@pytest.mark.parametrize("hidden", [0.0, 0.3])
def test_points_in_another_order_are_told_with_the_vertex_and_the_cure(order: list[int], hidden: float) -> None:
    points = worm(0.8)[:, order]
    points[np.random.default_rng(0).random(points.shape[:2]) < hidden] = np.nan
    said = folded(points)
    assert "is folded back at vertex" in said
    assert "Name them from tail to head" in said


@pytest.mark.parametrize("amplitude", [0.3, 0.8, 1.6])
def test_bodies_that_bend_far_are_not_folded(amplitude: float) -> None:
    assert folded(worm(amplitude)) == ""


def test_a_body_that_coils_for_a_while_and_points_in_one_place_are_not_folded() -> None:
    points = worm(0.8)
    points[:30] = points[:30, [0, 1, 2, 3, 4, 6, 7, 8, 5]]
    assert folded(points) == ""
    assert folded(np.zeros((20, 5, 2))) == folded(np.full((20, 5, 2), np.nan)) == folded(points[:3]) == ""
