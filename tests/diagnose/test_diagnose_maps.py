"""Residual maps: rigid motions as vertices make them, noise carried to vertices, bins that lose no window."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from serpenoid.diagnose.diagnose import Diagnosis
from serpenoid.diagnose.residuals.maps import Windows, by_phase, by_speed, by_time, on_floor, windows

ARM = np.linspace(-0.4, 0.4, 9)


def straight(before: np.ndarray, noise: np.ndarray, heading: float = 0.0) -> Windows:
    """A straight body along its heading, the same in every window."""
    count = len(before)
    points = np.tile(np.column_stack([ARM, np.zeros(9)]), (count, 1, 1))
    frame = np.tile([0.05, 0.05, heading], (count, 1))
    each = np.linspace(0, 0.9, count)
    return Windows(before, 0 * before, noise, each, 10 * each, each, frame, points, np.zeros((count, 9)))


def test_a_residual_that_pivots_about_a_vertex_vanishes_there() -> None:
    spin = 0.3
    residual = np.tile([0.0, -spin * ARM[6], spin], (5, 1))
    along, across = straight(residual, residual).along_body(residual).T
    assert along == pytest.approx(0, abs=1e-15)
    assert across == pytest.approx(spin * np.abs(ARM - ARM[6]), abs=1e-15)


def test_noise_at_vertices_is_the_scatter_of_random_residuals() -> None:
    noise = np.tile([2e-3, 1e-3, 8e-3], (40000, 1))
    drawn = np.random.default_rng(0).normal(0, noise)
    w = straight(drawn, noise)
    assert w.along_body(drawn) == pytest.approx(w.noise_along_body(), rel=0.02)  # 1 / sqrt(2 * 40000) = 0.004
    cells = on_floor(w, drawn)
    assert [c.rms for c in cells] == pytest.approx([c.noise for c in cells], rel=0.02)


def test_velocities_on_the_floor_turn_with_the_heading() -> None:
    residual = np.tile([1e-3, 0.0, 0.0], (20, 1))
    for heading in (0.0, 2.0):
        means = [c.mean for c in on_floor(straight(residual, residual, heading), residual)]
        assert np.array(means) == pytest.approx(np.tile([np.cos(heading), np.sin(heading)], (len(means), 1)) * 1e-3)


def test_bins_hold_every_window_once(diagnosed: tuple[Diagnosis, dict[str, Any], Any]) -> None:
    found = diagnosed[0].motion.selection
    w = windows(found.motion, found.null.predictions, found.best.predictions)
    for bins in (by_phase(w), by_speed(w), by_time(w)):
        assert sum(b.count for b in bins) == len(w.phase)
        assert sum(b.count * b.before for b in bins) == pytest.approx(w.before.sum(axis=0))
    assert [b.count for b in by_phase(w)][-1] == (~w.playing).sum()


def test_maps_show_the_floor_where_it_is_and_not_where_a_moved_frame_shows_it(
    diagnosed: tuple[Diagnosis, dict[str, Any], Any],
) -> None:
    found = diagnosed[0].motion.selection
    both = found.null.predictions, found.best.predictions
    w, jump = windows(found.motion, *both), np.array([0.1, -0.2, 0.0])
    tracks = [
        replace(t, poses=t.poses + away, shifted=t.shifted + away)
        for t in found.motion.tracks
        for away in [jump * (t.time > t.time.mean())[:, None]]
    ]
    seen = windows(replace(found.motion, tracks=tuple(tracks)), *both)
    for one, other in ((seen.vertices, w.vertices), (seen.speed, w.speed), (seen.points, w.points)):
        assert one == pytest.approx(other, abs=1e-12)


def test_residuals_are_chance_after_and_not_before(diagnosed: tuple[Diagnosis, dict[str, Any], Any]) -> None:
    body = diagnosed[1]["residual_maps"]["along_body"]
    assert len(body) == 12
    before, after = (
        np.array([v[k] for v in body]) / [v["noise_level"] for v in body] for k in ("before_rms", "after_rms")
    )
    assert before.max() > 5
    assert after == pytest.approx(1, abs=0.4)  # noise estimated from as many repeats
