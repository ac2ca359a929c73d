"""What the panels draw are the data."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from serpenoid.gaits import EllipseGait
from serpenoid.plot import joints
from serpenoid.plot.body import shapes
from serpenoid.plot.gait import gait_curve, shapes_around
from serpenoid.plot.motion import motion, over_cycles
from serpenoid.self_contact import crosses_itself

GAIT = EllipseGait(sigma=0.6, x_c=1, y_c=-1, theta=0.5, a=6, xi=1)


@pytest.fixture
def ax():
    return Figure().add_subplot()


def drawn(ax):
    return [np.column_stack(line.get_data()) for line in ax.lines]


def contains(ax, points):
    """Whether a line of `ax` goes through just these points."""
    return any(line.shape == points.shape and np.array_equal(line, points) for line in drawn(ax))


def test_gait_panel_draws_the_curve_and_a_dot_per_row(ax):
    gait_curve(GAIT, ax, rows=20)
    assert contains(ax, GAIT.curve(np.linspace(0, 1, 241)))
    np.testing.assert_array_equal(ax.collections[0].get_offsets(), GAIT.curve(np.arange(20) / 20))
    assert contains(ax, GAIT.curve(np.zeros(1)))
    assert ax.get_aspect() == 1.0


def test_shapes_around_a_gait_keep_their_form_and_clear_the_curve(ax, trajectory):
    frames = shapes(trajectory.poses[:-1], trajectory.vertices[:-1])
    shapes_around(GAIT, frames, ax)
    bodies = [line for line in drawn(ax) if len(line) == 12][::2]
    curve = GAIT.curve(np.linspace(0, 1, 500))
    assert len(bodies) in (4, 6, 8)
    for body in bodies:
        assert np.linalg.norm(body[:, None] - curve[None], axis=-1).min() > 0.05
    scale = np.ptp(bodies[0][:, 0]) / np.ptp(frames[0, :, 0])
    np.testing.assert_allclose(bodies[0] - bodies[0].mean(0), scale * frames[0], atol=1e-12)  # rounding of O(1) numbers


def test_body_frame_shapes_are_those_the_motion_was_made_of(trajectory):
    frames = shapes(trajectory.poses, trajectory.vertices)
    np.testing.assert_allclose(frames.mean(1), 0, atol=1e-15)
    np.testing.assert_allclose(frames[0], frames[-1], atol=1e-15)


def test_motion_panel_draws_vertices_and_centre_of_mass(ax, trajectory):
    motion(trajectory, ax, bodies=5)
    for row in (0, 5, 10, 15, 20):
        assert contains(ax, trajectory.vertices[row])
        assert contains(ax, trajectory.vertices[row, -1:])  # the head's mark
    assert contains(ax, trajectory.poses[:, :2])
    assert ax.get_aspect() == 1.0
    low, high = np.array(ax.viewLim.min), np.array(ax.viewLim.max)
    assert (trajectory.vertices >= low).all()
    assert (trajectory.vertices <= high).all()


def test_further_cycles_repeat_the_relative_motion(trajectory):
    poses, chains = over_cycles(trajectory, 3)
    assert poses.shape == (61, 3)
    assert chains.shape == (61, 12, 2)
    np.testing.assert_allclose(poses[:21], trajectory.poses, atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(np.diff(poses[::20, :2], axis=0), axis=1), 0.5, atol=1e-14)
    np.testing.assert_allclose(np.diff(poses[::20, 2]), 0.3, atol=1e-14)
    edges = np.linalg.norm(np.diff(chains, axis=1), axis=2)
    np.testing.assert_allclose(edges[:20], edges[20:40], atol=1e-14)


def test_joint_lines_are_the_table_in_degrees_and_limits_lie_at_the_limits(ax, table):
    joints.joint_angles(table, ax, limit_deg=60)
    closed = np.rad2deg(np.vstack([table, table[:1]]))
    for j in range(10):
        assert contains(ax, np.column_stack([np.arange(21) / 20, closed[:, j]]))
    levels = {line[0, 1] for line in drawn(ax) if len(line) == 2}
    assert levels == {0, 60, -60}
    assert max(ax.get_ylim()) > 60


def test_ranges_of_joints_are_drawn_where_they_end_and_in_their_colours_where_they_differ(ax, table):
    joints.joint_angles(table, ax, limit_deg=(-10, 60))
    assert {line[0, 1] for line in drawn(ax) if len(line) == 2} == {0, -10, 60}
    assert any("limit -10 to 60°" in text.get_text() for text in ax.texts)
    ax.clear()
    each = tuple((-10.0 - j, 60.0 + j) for j in range(10))
    joints.joint_angles(table, ax, limit_deg=each)
    ends = {y for pair in each for y in pair}
    assert {line[0, 1] for line in drawn(ax) if len(line) == 2} == {0, *ends}
    dashed = {line.get_ydata()[0]: line.get_color() for line in ax.lines if line.get_linestyle() == "--"}
    assert all((dashed[low] == dashed[high]).all() for low, high in each)
    low, high = ax.get_ylim()
    assert low < min(ends)
    assert max(ends) < high


def test_joint_speed_of_a_sine_is_its_derivative_and_its_limit_is_drawn(ax, table):
    fine = 0.6 * np.sin(2 * np.pi * np.arange(1000) / 1000)[:, None]
    rpm = joints.speeds_rpm(fine, cycle_duration_s=2.0)
    assert np.abs(rpm).max() == pytest.approx(0.6 * 2 * np.pi / 2 * 60 / (2 * np.pi), rel=1e-5)  # O(1 / T^2)
    speeds = joints.speeds_rpm(table, 2.0)
    near = 1.5 * float(np.abs(speeds).max())
    joints.joint_speeds(speeds, ax, limit_rpm=near)
    assert {line[0, 1] for line in drawn(ax) if len(line) == 2} == {0, near, -near}


def test_a_limit_far_beyond_the_speeds_is_told_and_leaves_them_the_picture(ax, table):
    speeds = joints.speeds_rpm(table, 2.0)
    reach = float(np.abs(speeds).max())
    joints.joint_speeds(speeds, ax, limit_rpm=7 * reach)
    assert max(ax.get_ylim()) < 1.5 * reach
    assert any("7 times what is reached" in text.get_text() for text in ax.texts)


def test_joint_map_shows_every_angle(ax, table):
    joints.joint_map(table, ax)
    np.testing.assert_array_equal(ax.collections[0].get_array(), np.rad2deg(table.T))


def test_a_chain_that_crosses_itself_is_seen():
    loop = np.array([[0, 0], [1, 0], [1, 1], [0.5, 1], [0.5, -1.0]])
    open_ = np.array([[0, 0], [1, 0], [1, 1], [0.5, 1], [0.5, 0.5]])
    assert crosses_itself(np.stack([loop, open_])).tolist() == [True, False]


@pytest.mark.parametrize("edges", [5, 25, 100, 200, 333])
def test_edges_of_a_straight_link_do_not_cross_however_many_they_are(edges):
    """A distant edge of the same line stands on either side of it by rounding alone; links that cross still do."""
    psi = np.random.default_rng(edges).uniform(-0.3, 0.3, (30, 1))
    share = np.arange(edges + 1)[:, None] / edges
    straight = share * np.stack([np.cos(psi), np.sin(psi)], -1) * 0.33
    assert not crosses_itself(straight).any()
    corners = np.array([[0, 0], [1, 0], [0.5, 1], [0.3, -0.7]])
    links = [(1 - share[:-1]) * a + share[:-1] * b for a, b in zip(corners[:-1], corners[1:], strict=True)]
    assert crosses_itself(np.concatenate(links)[None]).all()


def test_of_joints_that_hardly_move_no_number_is_told_of_how_far_the_limit_is(ax):
    joints.joint_angles(np.full((8, 3), 1.7e-4), ax, 70.0)
    assert [text.get_text() for text in ax.texts] == ["limit 70°, far above what is reached"]
