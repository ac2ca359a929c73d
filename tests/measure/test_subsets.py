"""Any part of the markers tells shape and pose, and a single one that is astray is no jump of the body."""

from __future__ import annotations

import numpy as np
import pytest

from rehearsal import serpenoid_table, snake
from serpenoid.body import Body
from serpenoid.compare.rehearse import Laboratory, write_campaign
from serpenoid.diagnose.data.shapes.shapes_from_points import from_points
from serpenoid.measure.consistency.signals import Signal
from serpenoid.measure.load import load_campaign
from serpenoid.measure.shapes.bends import bends_in_time
from serpenoid.measure.shapes.chain import completed, estimate_chain
from serpenoid.measure.shapes.links import chain_vertices
from serpenoid.measure.trial import build_motion

POINTS, FRAMES, RATE, SD = 11, 180, 30.0, 1e-3
TIME = np.arange(FRAMES) / RATE


def crawling(period_s: float = 1.7, amplitude: float = 0.7) -> tuple[Body, np.ndarray, np.ndarray, np.ndarray]:
    """An animal that bends in waves and is carried on: its body, poses, joint angles and points."""
    body = Body(vertices=POINTS, kind="crawler")
    phase = 2 * np.pi * (TIME[:, None] / period_s - 1.2 * np.arange(POINTS - 2) / POINTS)
    angles = amplitude * np.sin(phase)
    poses = np.stack([0.25 * TIME, 0.02 * np.sin(TIME), 0.3 * np.sin(0.5 * TIME)], axis=1)
    return body, poses, angles, chain_vertices(body, poses, angles)


def seen(points: np.ndarray, lost: float, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    found = points + rng.normal(scale=SD, size=points.shape)
    found[rng.random(points.shape[:2]) < lost] = np.nan
    return found


def test_frames_of_which_single_points_are_lost_are_not_dropped():
    """Of 12 % lost points a third of the frames was: in a stretch that is nearly straight links leave a point open."""
    body, poses, angles, points = crawling()
    motion, _, _ = build_motion(body, TIME, seen(points, 0.12, 0), None, ((), ()))
    assert motion.measured.mean() > 0.97
    assert len(motion.runs) == 1
    rows = motion.runs[0]
    # what the paths may miss: noise of points, half a link long, smoothed, and a few of them guessed
    assert np.sqrt(np.mean((motion.smooth_angles[rows] - angles[rows]) ** 2)) < SD * (POINTS - 1)
    assert np.sqrt(np.mean((motion.smooth_poses[rows, :2] - poses[rows, :2]) ** 2)) < SD


@pytest.mark.parametrize("period_s", [1.7, 0.5])
def test_bends_of_the_frames_about_are_as_far_off_as_is_said(period_s):
    body, _, angles, points = crawling(period_s)
    markers = seen(points, 0.12, 1)
    alone = estimate_chain(body, markers)
    variance = np.diagonal(alone.covariance[:, 3:, 3:], axis1=1, axis2=2)
    said = bends_in_time(body, TIME, markers, alone.joint_angles, variance, alone.determined)
    there = np.isfinite(said.sd)
    assert there.sum() > 100
    z = (said.angles - angles)[there] / said.sd[there]
    assert 0.6 < np.sqrt(np.mean(z**2)) < 1.2  # no less than is said, by the scatter of some 50 independent ones


def test_a_point_that_is_hidden_for_long_is_where_the_rest_of_the_wave_says():
    """Straight lines in time over most of a beat cut its corners; the same frame shows the wave that runs on."""
    body, poses, angles, points = crawling(0.5)
    markers = seen(points, 0.0, 2)
    markers[60:72, -1] = markers[90:98, 4] = np.nan
    motion, _, _ = build_motion(body, TIME, markers, None, ((), ()))
    assert motion.measured.all()
    assert np.abs(motion.smooth_angles - angles).max() < 0.1  # of 0.7; by lines up to 1.1
    assert np.abs(motion.smooth_poses - poses)[:, :2].max() < 4 * SD


def test_a_point_of_which_nothing_else_tells_stays_open():
    """Where a head goes its own way, neither the body nor frames that are far away say where: such frames are left."""
    body, poses, angles, _ = crawling(0.5)
    angles[:, -1] = 0.7 * np.sin(2 * np.pi * TIME / 0.37)
    markers = seen(chain_vertices(body, poses, angles), 0.0, 2)
    markers[60:80, -1] = np.nan  # no link closes behind it
    found = completed(body, markers, TIME, estimate_chain(body, markers))
    assert not found.determined[63:77].any()
    assert found.determined[:60].all()


def test_lost_points_are_no_gap_because_all_others_have_hardly_any_noise():
    """What is not known must be known as well as is of use; points without noise refused films that noise let pass."""
    body, _, angles, points = crawling(0.5)
    exact = points + 1e-6 * np.random.default_rng(0).normal(size=points.shape)
    exact[np.random.default_rng(1).random(points.shape[:2]) < 0.12] = np.nan
    motion, _, _ = build_motion(body, TIME, exact, None, ((), ()))
    assert motion.measured.mean() > 0.97
    assert np.nanmax(np.abs(motion.smooth_angles - angles)) < 0.1


def test_a_frame_that_is_whole_is_estimated_as_before_and_others_better():
    body, _, angles, points = crawling()
    markers = seen(points, 0.12, 0)
    alone = estimate_chain(body, markers)
    both = completed(body, markers, TIME, alone)
    whole = np.isfinite(markers).all(axis=(1, 2))
    np.testing.assert_array_equal(both.joint_angles[whole], alone.joint_angles[whole])
    assert both.determined.sum() > alone.determined.sum()
    part = alone.determined & ~whole
    before, now = (np.sqrt(np.mean((each.joint_angles - angles)[part] ** 2)) for each in (alone, both))
    assert now < 0.7 * before


def astray(points: np.ndarray, count: int, frames: int, seed: int) -> tuple[np.ndarray, set[tuple[int, int]]]:
    """Points of which some are 0.06 to 0.3 body lengths off for some frames; which they are."""
    rng, found, which = np.random.default_rng(seed), seen(points, 0.03, seed), set()
    for begin in rng.choice(np.arange(10, FRAMES - 10, 10), count, replace=False):
        k, way = int(rng.integers(POINTS)), rng.uniform(0, 2 * np.pi)
        for frame in range(begin, begin + frames):
            if np.isfinite(found[frame, k, 0]):
                found[frame, k] += rng.uniform(0.06, 0.3) * np.array([np.cos(way), np.sin(way)])
                which.add((frame, k))
    return found, which


@pytest.mark.parametrize(("frames", "seed"), [(1, 0), (1, 1), (4, 2)])
def test_a_single_point_that_is_astray_is_left_out_and_the_body_does_not_jump(frames, seed):
    body, poses, _, points = crawling()
    markers, which = astray(points, 12, frames, seed)
    motion, _, _ = build_motion(body, TIME, markers, None, ((), ()))
    assert not [jump for jump in motion.jumps if jump.vertex is None]
    told = {(jump.frame, jump.vertex) for jump in motion.jumps}
    assert told <= which
    assert len(told) >= 0.9 * len(which)  # some are off along a way that the links allow
    assert all(np.isnan(motion.markers[frame, k]).all() for frame, k in told)
    rows = motion.runs[0]
    assert np.sqrt(np.mean((motion.smooth_poses[rows, :2] - poses[rows, :2]) ** 2)) < SD


@pytest.mark.parametrize("size", [0.1, 5.0])
@pytest.mark.parametrize("frames", [1, 4])
@pytest.mark.parametrize("at_end", [False, True])
def test_a_point_that_is_astray_where_a_film_begins_or_ends_is_left_out(size, frames, at_end):
    """Without it all smoothing follows: of a worm with K = 5 one such point in four of 401 frames made 5.49."""
    body, poses, _, points = crawling()
    for seed, vertex in enumerate((0, POINTS // 2, POINTS - 1)):
        markers = seen(points, 0.0, seed)
        rows = slice(FRAMES - frames, FRAMES) if at_end else slice(0, frames)
        way = np.random.default_rng(seed).uniform(0, 2 * np.pi)
        markers[rows, vertex] += size * np.array([np.cos(way), np.sin(way)])
        motion, _, _ = build_motion(body, TIME, markers, None, ((), ()))
        told = {(jump.frame, jump.vertex) for jump in motion.jumps}
        if size > 1 or 0 < vertex < POINTS - 1:  # links allow an end to be elsewhere beside its neighbour
            assert told == {(frame, vertex) for frame in np.arange(FRAMES)[rows].tolist()}
            assert np.isnan(motion.markers[rows, vertex]).all()
        known = motion.runs[0]
        assert np.sqrt(np.mean((motion.smooth_poses[known, :2] - poses[known, :2]) ** 2)) < SD


@pytest.mark.parametrize(("rows", "frame"), [(slice(0, 1), 1), (slice(FRAMES - 1, FRAMES), FRAMES - 1)])
def test_a_body_that_is_elsewhere_in_the_first_or_last_frame_alone_jumps(rows, frame):
    body, _, _, points = crawling()
    markers = seen(points, 0.0, 5)
    markers[rows] += np.array([0.5, 0.3])
    motion, _, _ = build_motion(body, TIME, markers, None, ((), ()))
    assert [(jump.frame, jump.vertex) for jump in motion.jumps] == [(frame, None)]


def test_a_body_that_jumps_as_a_whole_still_jumps():
    body, _, _, points = crawling()
    markers = seen(points, 0.03, 5)
    markers[90:] += np.array([0.1, 0.0])
    motion, _, _ = build_motion(body, TIME, markers, None, ((), ()))
    assert [(jump.frame, jump.vertex) for jump in motion.jumps] == [(90, None)]
    assert len(motion.runs) == 2


@pytest.mark.filterwarnings("error")
def test_a_robot_without_a_log_of_which_a_quarter_of_the_markers_is_hidden_is_measured(tmp_path):
    """Rows in which all markers are seen are few, and too far apart to be laid over a table: no verdict on them."""
    lab = Laboratory(frames_per_second=30.0, hidden_share=0.25)
    write_campaign(tmp_path, snake(), {"g": serpenoid_table(50)}, lab, 1, 14000, cycles=1, pause_s=1.0)
    text = (tmp_path / "campaign.toml").read_text()
    (tmp_path / "campaign.toml").write_text(text.replace('servo_log = "g-1/servo.csv"\n', ""))
    (trial,) = load_campaign(tmp_path).trials
    assert trial.motion.measured.mean() > 0.8
    assert len(trial.passages) == 1


def test_rows_that_are_far_apart_are_not_enough_to_be_laid_over_anything():
    angles = np.sin(2 * np.pi * TIME)[:, None]
    assert Signal(TIME, angles).enough
    few = np.where((np.arange(FRAMES) % 6 == 0)[:, None], angles, np.nan)
    assert not Signal(TIME, few).enough


def test_a_diagnosis_sees_a_body_with_hidden_points_as_it_bends():
    """Straight lines over what is hidden were taken for the body's shape: drag alone was then "unexplained"."""
    body, _, angles, points = crawling(0.5)
    markers = seen(points, 0.0, 4)
    for k in range(20):
        markers[8 * k : 8 * k + 6, k % POINTS] = np.nan
    motion, _, _ = build_motion(body, TIME, markers, None, ((), ()))
    near = chain_vertices(body, motion.smooth_poses, motion.smooth_angles)
    found = from_points(body, TIME, markers, near).states
    assert np.sqrt(np.mean((found.angles - angles) ** 2)) < 2 * SD * (POINTS - 1)
