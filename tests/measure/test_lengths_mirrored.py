"""Lengths of a body are those of its film, however that is mirrored or turned."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.body import Body
from serpenoid.measure.lengths import _cuts_corners, shown_lengths

BODY = Body(vertices=6, kind="crawler")


def smooth_and_raw(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A body that bends (F, N, 2) [m], and the same with noise that lengthens it nearly as much as smoothing cut."""
    rng = np.random.default_rng(seed)
    time, along = np.linspace(0, 6, 60)[:, None], np.arange(6)
    turned = 0.5 * np.sin(2 * np.pi * time - along[:-1])
    steps = 0.1 * np.stack([np.cos(turned), np.sin(turned)], axis=-1)
    points = np.concatenate([np.zeros((60, 1, 2)), np.cumsum(steps, axis=1)], axis=1)
    return points, points * 1.0012 + rng.normal(scale=0.002, size=points.shape)


@pytest.mark.parametrize("mirror", [(1, -1), (-1, 1), (-1, -1)])
def test_whether_smoothing_cuts_corners_is_the_same_of_a_mirrored_film(mirror):
    answers = []
    for seed in range(60):
        smoothed, raw = smooth_and_raw(seed)
        each = [
            _cuts_corners(BODY, shown_lengths(BODY, raw * m), smoothed * m, shown_lengths(BODY, smoothed * m))
            for m in ((1, 1), mirror)
        ]
        assert each[0] == each[1]
        answers.append(each[0])
    assert 0 < sum(answers) < 60  # films on both sides of the decision
