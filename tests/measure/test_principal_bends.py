"""Bends of a whole body, known exactly, seen through points that scatter by a third of the distance between them."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.body import Body
from serpenoid.measure.shapes.chain import estimate_chain
from serpenoid.measure.shapes.links import chain_vertices, marker_angles
from serpenoid.measure.shapes.principal_bends import BendFinder, PrincipalBends
from serpenoid.measure.shapes.smooth import cross_validated, smooth

POINTS, FRAMES, NOISE = 31, 200, 0.003  # body lengths; an edge is 0.033
BODY = Body(kind="crawler", vertices=POINTS)
TIME = np.arange(FRAMES) / 30
FINDER = BendFinder.of(BODY, TIME)


def true_angles() -> np.ndarray:
    s = np.linspace(0, 1, POINTS)[1:-1]
    return 0.15 * np.sin(2 * np.pi * (0.5 * TIME[:, None] - 1.2 * s)) + 0.03 * np.cos(0.9 * TIME[:, None])


def seen(noise: float, seed: int) -> np.ndarray:
    """Joint angles (F, m) that points with noise show."""
    true = points(true_angles())
    return marker_angles(BODY, true + np.random.default_rng(seed).normal(0, noise, true.shape))


def points(angles: np.ndarray) -> np.ndarray:
    return chain_vertices(BODY, np.zeros((FRAMES, 3)), angles)


def off(angles: np.ndarray, quiet: np.ndarray) -> float:
    return float(np.sqrt(((angles - quiet) ** 2).mean()))


def found(seed: int) -> tuple[PrincipalBends, np.ndarray]:
    angles = seen(NOISE, seed)
    return FINDER.bends(angles), angles


def test_bends_of_the_whole_body_are_nearer_the_truth_than_joints_one_by_one() -> None:
    bends, angles = found(1)
    quiet = seen(0.0, 0)
    joints = cross_validated(TIME, angles)
    assert joints is not None
    of_bends, of_joints, true = (points(a) for a in (bends.smoothed(angles), smooth(angles, *joints), quiet))
    assert off(of_bends, true) < 0.5 * off(of_joints, true)  # 5 bends instead of 29 joints: root of 5 / 29 is 0.42


def test_what_smoothing_takes_out_is_as_large_as_the_noise() -> None:
    bends, angles = found(2)
    quiet = seen(0.0, 0)
    assert bends.noise(angles).std() == pytest.approx((angles - quiet).std(), rel=0.05)  # 5800 numbers


def test_without_noise_nothing_is_taken_out() -> None:
    """What a window of five frames, the shortest, leaves of a wave with sixty frames a period: 1e-5 of it."""
    quiet = seen(0.0, 0)
    assert off(FINDER.bends(quiet).smoothed(quiet), quiet) < 1e-4 * quiet.std()


def test_a_body_that_keeps_its_shape_has_its_mean_shape() -> None:
    rng = np.random.default_rng(3)
    angles = 0.1 + rng.normal(0, 0.05, (FRAMES, POINTS - 2))
    smoothed = FINDER.bends(angles).smoothed(angles)
    assert off(smoothed, np.full_like(angles, 0.1)) < 2.5 * 0.05 / np.sqrt(FRAMES)  # of the mean: 0.05 / sqrt(FRAMES)


def test_smoothing_is_affine_so_that_draws_of_noise_can_be_smoothed_alike() -> None:
    bends, angles = found(4)
    more = np.random.default_rng(5).normal(0, 0.1, angles.shape)
    parts = bends.smoothed(angles) + bends.smoothed(more) - bends.smoothed(np.zeros_like(more))
    np.testing.assert_allclose(bends.smoothed(angles + more), parts, atol=1e-12)


def test_the_chain_fit_shows_the_same_bends() -> None:
    """Another route: angles of a curve fitted to all points at once, smoothed as bends."""
    bends, angles = found(6)
    true = points(true_angles())
    fitted = estimate_chain(BODY, true + np.random.default_rng(6).normal(0, NOISE, true.shape)).joint_angles
    other = FINDER.bends(fitted).smoothed(fitted)
    assert off(bends.smoothed(angles), other) < 0.2 * off(angles, seen(0.0, 0))
