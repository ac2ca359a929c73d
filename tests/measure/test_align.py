"""Alignment: chains, clocks, labels, gaps and jumps, each with the truth known."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from rehearsal import serpenoid_table, snake
from serpenoid.body import Body
from serpenoid.errors import InputError
from serpenoid.measure import clock
from serpenoid.measure.clock import find_offset, interpolate, interpolate_smoothly
from serpenoid.measure.film.quality import find_gaps, find_holes, find_jumps
from serpenoid.measure.film.relabel import label_vertices
from serpenoid.measure.schedule import Schedule, start_by_shape
from serpenoid.measure.shapes.chain import estimate_about, estimate_chain
from serpenoid.measure.shapes.links import chain_vertices
from serpenoid.measure.shapes.smooth import smooth_states
from serpenoid.measure.tracks import Tracks, floor_plane
from serpenoid.measure.trial import build_motion

SD = 0.0002 / 0.836  # 0.2 mm on the snake, in body lengths


def _motion(frames: int = 120) -> tuple[Body, np.ndarray, np.ndarray, np.ndarray]:
    body = snake().body
    angles = serpenoid_table(frames)
    time = np.arange(frames) / 60
    poses = np.stack([0.3 * time, 0.1 * np.sin(time), 2.9 + 0.4 * time], axis=1)  # the heading passes pi
    return body, poses, angles, chain_vertices(body, poses, angles)


def test_floor_is_right_handed_seen_from_above():
    x, y, z = np.eye(3)
    for up, first, second in (("y", z, x), ("z", x, y), ("x", y, z)):
        plane = floor_plane(np.stack([first, second]), up)
        np.testing.assert_array_equal(plane, np.eye(2))
        assert np.dot(np.cross(first, second), {"x": x, "y": y, "z": z}[up]) == 1


def test_exact_markers_give_back_pose_and_joint_angles():
    body, poses, angles, vertices = _motion()
    found = estimate_chain(body, vertices, marker_sd=SD)
    np.testing.assert_allclose(found.joint_angles, angles, atol=1e-9)  # rounding only
    np.testing.assert_allclose(found.poses[:, :2], poses[:, :2], atol=1e-9)
    turns = (found.poses[:, 2] - poses[:, 2]) / (2 * np.pi)
    np.testing.assert_allclose(turns, np.round(turns[0]), atol=1e-9)


def test_rigid_vertices_between_joints_are_kept_straight():
    body = Body(vertices=7, joints=(2, 4))
    poses, angles = np.zeros((9, 3)), np.stack([np.linspace(-1, 1, 9), np.linspace(0.5, -0.5, 9)], axis=1)
    found = estimate_chain(body, chain_vertices(body, poses, angles), marker_sd=SD)
    np.testing.assert_allclose(found.joint_angles, angles, atol=1e-9)


def test_covariance_is_the_scatter_of_repeated_measurements():
    body, poses, angles, vertices = _motion(12)
    rng, frame = np.random.default_rng(1), 5
    seen = np.repeat(vertices[frame][None], 4000, axis=0) + rng.normal(scale=SD, size=(4000, *vertices[frame].shape))
    about = np.repeat(poses[frame][None], 4000, axis=0), np.repeat(angles[frame][None], 4000, axis=0)
    found = estimate_about(body, seen, *about, marker_sd=SD)
    state = np.concatenate([found.poses, found.joint_angles], axis=1)
    # a variance from 4000 draws is known to 1 / sqrt(2000) = 2.2 %; four of those
    np.testing.assert_allclose(state.var(axis=0), np.diag(found.covariance[0]), rtol=0.09)


def test_marker_noise_is_found_from_the_misfit_of_the_links():
    body, _, _, vertices = _motion(400)
    rng = np.random.default_rng(2)
    found = estimate_chain(body, vertices + rng.normal(scale=SD, size=vertices.shape))
    assert found.marker_sd == pytest.approx(SD, rel=0.05)  # 4400 degrees of freedom: 1 %; trimming costs some


def test_a_vertex_hidden_while_the_body_turns_is_bent_to_its_own_side():
    body, frames = Body(vertices=6), 60
    turn = np.linspace(0, 1, frames)
    poses = np.stack([0 * turn, 0 * turn, 1.4 * np.pi * turn], axis=1)  # more than half a turn
    angles = np.stack([0.4 + 0.5 * turn, 0.9 - 0.3 * turn, 0.5 + 0.3 * turn, -0.2 + 0.2 * turn], axis=1)
    vertices = chain_vertices(body, poses, angles)
    vertices[5:-5, 2] = np.nan
    found = estimate_chain(body, vertices, marker_sd=SD)
    assert found.determined.all()
    np.testing.assert_allclose(found.joint_angles, angles, atol=1e-6)  # not the mirrored bend, nor whole turns beside


def test_a_hidden_vertex_is_found_by_its_links_and_a_hidden_head_is_not():
    body, _, angles, vertices = _motion()
    vertices[40, 5] = np.nan
    vertices[50, -1] = np.nan
    found = estimate_chain(body, vertices, marker_sd=SD)
    assert found.determined[40]
    np.testing.assert_allclose(found.joint_angles[40], angles[40], atol=1e-6)
    assert not found.determined[50]
    servo = estimate_chain(body, vertices, angles, 0.002, SD)
    assert servo.determined[50]  # the servo knows where the head link points
    np.testing.assert_allclose(servo.joint_angles[50], angles[50], atol=1e-6)


def test_a_long_recording_takes_little_more_room_than_what_is_known_of_it():
    """No matrix of all frames but the covariance: a frame's Jacobian is twice as large."""
    body, _, _, true = _motion(8192)
    seen = true + SD * np.random.default_rng(5).standard_normal(true.shape)
    tracemalloc.start()
    try:
        found = estimate_chain(body, seen, marker_sd=SD)
        fitted = tracemalloc.get_traced_memory()[1]
        tracemalloc.reset_peak()
        smooth_states(np.arange(8192) / 60, found.poses, found.joint_angles, found.covariance)
        smoothed = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert fitted < 5 * found.covariance.nbytes  # all at once: 9 times
    assert smoothed < 4.5 * found.covariance.nbytes  # all at once: 5.6 times
    part = estimate_chain(body, seen[2000:2100], marker_sd=SD)  # across the end of a block
    np.testing.assert_allclose(part.joint_angles, found.joint_angles[2000:2100], atol=1e-12)


def test_smooth_path_is_nearer_to_the_truth_than_the_measurements():
    body, poses, angles, vertices = _motion(600)
    rng = np.random.default_rng(3)
    found = estimate_chain(body, vertices + rng.normal(scale=SD, size=vertices.shape), marker_sd=SD)
    _, smooth = smooth_states(np.arange(600) / 60, found.poses, found.joint_angles, found.covariance)
    assert (smooth - angles).std() < 0.5 * (found.joint_angles - angles).std()


@pytest.mark.parametrize("since", [0.0, 1.7e9], ids=["since-the-start", "since-1970"])
def test_clock_offset_is_found_and_not_mistaken_by_a_cycle(since):
    schedule = Schedule(serpenoid_table(50), 2.0, 3, 1.0, start_s=since + 5.0)
    time = since + np.arange(4.0, 15.0, 1 / 60)
    rng = np.random.default_rng(0)
    angles = schedule.commanded(time) + rng.normal(scale=0.005, size=(len(time), 10))
    log_time = since + np.arange(5.0, 14.0, 0.02)
    found = find_offset(time, angles, log_time - 3.217, schedule.commanded(log_time))
    assert found is not None
    assert found.offset_s == pytest.approx(3.217, abs=0.002)  # a tenth of a frame
    again = start_by_shape(Schedule(schedule.table, 2.0, 3, 1.0), time, angles)
    assert again is not None
    assert again.offset_s == pytest.approx(since + 5.0, abs=0.002)


def _tracks(vertices: np.ndarray, names: list[str]) -> Tracks:
    return Tracks(np.arange(len(vertices)) / 60, tuple(names), vertices, "a.csv", tuple("Unl" in n for n in names))


def test_unlabelled_fragments_find_their_vertices():
    body, _, _, vertices = _motion()
    names = [f"v{k}" for k in range(12)]
    broken = vertices.copy()
    broken[30:70, 4] = broken[50:90, 11] = np.nan
    fragments = np.full((len(vertices), 3, 2), np.nan)
    fragments[31:69, 0], fragments[55:88, 1] = vertices[31:69, 4], vertices[55:88, 11]
    fragments[:, 2] = [5.0, 5.0]  # a reflection on the floor
    tracks = _tracks(np.concatenate([broken, fragments], axis=1), [*names, "Unlabeled 7", "Unlabeled 9", "Unlabeled 3"])
    found = label_vertices(tracks, tuple(names), body.edges, 12, False)
    assert dict(found.relabelled) == {"Unlabeled 7": 4, "Unlabeled 9": 11}
    assert found.unused == ("Unlabeled 3",)
    np.testing.assert_array_equal(found.vertices[31:69, 4], vertices[31:69, 4])


def test_a_misspelt_marker_is_refused_and_not_taken_for_hidden():
    body, _, _, vertices = _motion()
    names = [f"Snake:joint_{k}" for k in range(12)]
    tracks = _tracks(vertices, [*names[:3], "Snake:jiont_3", *names[4:]])
    with pytest.raises(InputError, match="names `Snake:joint_3`, not in this file.*Did you mean `Snake:jiont_3`"):
        label_vertices(tracks, tuple(names), body.edges, 12, False)
    without = _tracks(np.delete(vertices, 3, axis=1), [*names[:3], *names[4:]])  # lost, and nothing there instead
    assert np.isnan(label_vertices(without, tuple(names), body.edges, 12, False).vertices[:, 3]).all()


def test_a_chain_without_any_name_is_recognised_by_its_edges():
    edges = np.array([0.1, 0.2, 0.3, 0.4])
    body = Body(vertices=5, edge_lengths=tuple(edges))
    angles = 0.4 * np.sin(np.arange(40)[:, None] / 6 + np.arange(3))
    vertices = chain_vertices(body, np.zeros((40, 3)), angles)
    order = [3, 0, 4, 1, 2]
    tracks = _tracks(vertices[:, order], [f"Unlabeled {k}" for k in order])
    found = label_vertices(tracks, None, body.edges, 5, False)
    np.testing.assert_array_equal(found.vertices, vertices)


def test_a_symmetric_chain_without_any_name_is_refused():
    body = Body(vertices=4)
    vertices = chain_vertices(body, np.zeros((9, 3)), np.full((9, 2), 0.3))
    with pytest.raises(InputError, match="fits 2 ways round.*Name at least the head or tail"):
        label_vertices(_tracks(vertices, [f"Unlabeled {k}" for k in range(4)]), None, body.edges, 4, False)


def test_gaps_are_runs_of_undetermined_frames():
    known = np.array([1, 1, 0, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1], dtype=bool)
    short, long = find_gaps(known, np.arange(16) / 60, known)
    assert (short.first, short.last, short.short) == (2, 2, True)
    assert (long.first, long.last, long.short) == (6, 13, False)


@pytest.mark.parametrize("frames_per_second", [3.0, 8.0, 15.0, 60.0])
def test_a_frame_that_is_lost_alone_is_bridged_at_any_rate_and_two_where_that_is_short(frames_per_second: float):
    known = np.array([1, 1, 0, 1, 1, 1, 0, 0, 1, 1], dtype=bool)
    time, none = np.arange(10) / frames_per_second, np.zeros(10, dtype=bool)
    one, two = find_gaps(known, time, none)
    assert (one.short, two.short) == (True, frames_per_second == 60.0)
    assert not len(find_holes(np.delete(time, 4)))
    assert find_holes(np.delete(time, [4, 5])).tolist() == ([] if frames_per_second == 60.0 else [4])


def test_a_slow_frame_whose_points_do_not_tell_the_chain_is_a_gap():
    known = np.array([1, 1, 1, 0, 1, 1, 1], dtype=bool)
    (gap,) = find_gaps(known, np.arange(7) / 8, np.ones(7, dtype=bool))
    assert not gap.short


def test_a_bumped_camera_is_found_and_nothing_where_nothing_happened():
    body, _, _, vertices = _motion(300)
    rng = np.random.default_rng(4)
    vertices = vertices + rng.normal(scale=SD, size=vertices.shape)
    time = np.arange(300) / 60
    calm = estimate_chain(body, vertices)
    assert find_jumps(calm.poses, calm.covariance, calm.marker_residual, calm.marker_sd, time) == ()
    vertices[150:] += [0.02, -0.01]
    vertices[80, 3] += [0.0, 0.03]
    found = estimate_chain(body, vertices)
    jumps = find_jumps(found.poses, found.covariance, found.marker_residual, found.marker_sd, time)
    whole = [j for j in jumps if j.vertex is None]
    assert [j.frame for j in whole] == [150]
    assert whole[0].size == pytest.approx(np.hypot(0.02, 0.01), rel=0.1)
    assert [(j.frame, j.vertex) for j in jumps if j.vertex is not None] == [(80, 3)]


def test_a_recording_seen_with_other_lengths_is_cut_where_it_was_cut():
    """Or the jackknife over lengths would compare stretches that one of them does not have."""
    body, _, _, vertices = _motion(120)
    rng = np.random.default_rng(7)
    time, vertices = np.arange(120) / 60, vertices + rng.normal(scale=SD, size=vertices.shape)
    vertices[90:] += [0.02, -0.01]  # a bumped camera
    own, _, _ = build_motion(body, time, vertices, None, ((), ()))
    assert [(run.start, run.stop) for run in own.runs] == [(0, 90), (90, 120)]
    elsewhere = replace(own, runs=(slice(0, 60), slice(70, 120)))
    made, _, _ = build_motion(body, time, vertices, None, ((), ()), elsewhere)
    assert made.runs == elsewhere.runs
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(made.smooth_poses[:, 0])), np.arange(60, 70))


def test_schedule_holds_row_zero_in_pauses():
    table = serpenoid_table(20)
    schedule = Schedule(table, 2.0, 2, 1.0, start_s=10.0)
    np.testing.assert_allclose(
        schedule.commanded(np.array([9.0, 10.0, 12.0, 12.9, 13.0, 16.5, 40.0])), np.tile(table[0], (7, 1))
    )
    np.testing.assert_allclose(schedule.commanded(np.array([10.5]))[0], table[5])


@pytest.mark.parametrize("seed", [1, 20, 24, 54])
def test_holes_in_the_record_do_not_move_a_clock_by_most_of_a_cycle(seed: int) -> None:
    rng, cycle_s = np.random.default_rng(seed), 1.55

    def motion(time: np.ndarray) -> np.ndarray:
        phase = np.clip(time, 0.0, 2 * cycle_s) / cycle_s
        shift = 0.3 * np.arange(4)
        return np.sin(2 * np.pi * (phase[:, None] + shift)) - np.sin(2 * np.pi * shift)

    camera, log = np.arange(-0.7, 5.4, 1 / 30), np.arange(-1.1, 4.9, 0.09)
    holes = rng.uniform(-0.7, 5.4, 6)
    camera = camera[np.abs(camera[:, None] - holes).min(axis=1) > 0.3]
    seen = motion(camera) + rng.normal(scale=0.01, size=(len(camera), 4))
    found = find_offset(camera + 3.0, seen, log, motion(log))
    assert found is not None
    assert found.offset_s == pytest.approx(3.0, abs=0.02)  # straight lines between the log's rows, 0.09 s apart


def test_a_log_on_the_search_grid_is_laid_over_to_its_last_row() -> None:
    """4.188 + 281 * 0.04 is more than the last time of a log that was written with three decimals."""
    log = np.round(4.188 + 0.04 * np.arange(282), 3)
    assert np.arange(log[0], log[-1], 0.04)[-1] > log[-1]  # else this shows nothing
    schedule = Schedule(serpenoid_table(50), 4.0, 2, 1.0)
    at = np.arange(-1.0, 11.0, 0.02)
    found = find_offset(log, schedule.commanded(log - 5.05), at, schedule.commanded(at))
    assert found is not None
    assert found.offset_s == pytest.approx(5.05, abs=1e-4)


def test_a_log_keeps_the_amplitude_of_what_it_reads_between_its_rows():
    """Thirty rows a second of a cycle in 3 s: straight lines would lose 0.04 % of the amplitude (6e-4 at most)."""
    time, asked = np.arange(0, 6, 1 / 30), np.linspace(0.2, 5.8, 700)
    swing = np.sin(2 * np.pi * time / 3)[:, None]
    away = interpolate_smoothly(time, swing, asked)[:, 0] - np.sin(2 * np.pi * asked / 3)
    assert np.abs(away).max() < 1e-5


def test_a_log_goes_nearly_straight_across_a_hole_and_ends_where_its_rows_end():
    time = np.delete(np.arange(0, 6, 1 / 30), slice(40, 60))
    swing, asked = np.sin(2 * np.pi * time / 3)[:, None], np.linspace(-0.1, 6.1, 621)
    found, straight = interpolate_smoothly(time, swing, asked), interpolate(time, swing, asked)
    np.testing.assert_array_equal(np.isnan(found), np.isnan(straight))
    assert np.nanmax(np.abs(found - straight)) < 0.005
    np.testing.assert_allclose(interpolate_smoothly(time, swing, time), swing, atol=1e-14)


def test_of_a_long_record_that_ends_amid_motion_a_part_of_its_rows_chooses_the_shift(monkeypatch):
    """With all rows the time would go with the square of the length: more shifts are tried, each on more rows."""
    schedule = Schedule(serpenoid_table(40), 3.0, 40, 1.0)
    time = np.arange(0, 155.0, 1 / 500)  # the log ends amid a cycle
    log = np.arange(0, 150.0, 1 / 30)
    rows = []
    chosen = clock._not_held
    monkeypatch.setattr(clock, "_not_held", lambda *args: rows.append(len(args[2])) or chosen(*args))
    found = find_offset(time, schedule.commanded(time - 2.0), log + 7.0, schedule.commanded(log - 2.0))
    assert found.offset_s == pytest.approx(-7.0, abs=1e-4)
    assert max(rows) < 2 * clock.MOST_ROWS < len(time)


def test_records_whose_best_shift_leaves_no_row_in_common_have_no_offset():
    """A film in milliseconds: between two of its frames lies all that a log tells."""
    time = np.arange(0.0, 3.0, 0.01)
    angles = np.stack([np.sin(1.3 * time), np.cos(1.3 * time)], axis=1)
    found = find_offset(10_000 * time, angles, time + 50.0, angles)
    assert found is None or np.isfinite(found.correlation)
