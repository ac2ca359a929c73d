"""Chains and registration against each other."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.body import Body
from serpenoid.diagnose.data.shapes.geometry import register, shapes, turn
from serpenoid.group import accumulate, relative
from serpenoid.measure.shapes.links import marker_angles

BODY = Body(vertices=12, edge_lengths=(0.04, *[0.08] * 9, 0.04), weights=tuple(range(1, 13)))


@pytest.fixture
def angles() -> np.ndarray:
    return np.random.default_rng(0).uniform(-0.8, 0.8, (7, 10))


def test_markers_of_a_chain_show_its_joint_angles(angles: np.ndarray) -> None:
    assert marker_angles(BODY, shapes(BODY, angles)) == pytest.approx(angles, abs=1e-12)


def test_the_weighted_centroid_of_a_shape_is_the_origin(angles: np.ndarray) -> None:
    assert np.einsum("k,fki->fi", BODY.vertex_weights, shapes(BODY, angles)) == pytest.approx(0, abs=1e-15)


def test_registration_finds_the_pose_with_markers_hidden(angles: np.ndarray) -> None:
    points = shapes(BODY, angles)
    pose = np.random.default_rng(1).uniform(-1, 1, (7, 3))
    markers = pose[:, None, :2] + turn(pose[:, None, 2], points)
    markers[:, [2, 7]] = np.nan
    found, left = register(points, markers)
    assert found == pytest.approx(pose, abs=1e-12)
    assert np.nanmax(np.abs(left)) < 1e-12


def test_travel_undoes_relative() -> None:
    poses = np.random.default_rng(2).uniform(-1, 1, (9, 3))
    assert accumulate(relative(poses[:-1], poses[1:]), poses[0]) == pytest.approx(poses, abs=1e-12)
