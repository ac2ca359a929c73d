"""The README's picture: a gait in shape space, the motion it makes, and its joint table."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from serpenoid.plot import joints
from serpenoid.plot.body import shapes
from serpenoid.plot.gait import gait_curve, shapes_around, start_label
from serpenoid.plot.motion import motion
from serpenoid.plot.style import PHASE_MAP, colour_bar, figure

if TYPE_CHECKING:
    from serpenoid.optimise.solution import Solution


def hero(solution: Solution, cycles: int = 3) -> Figure:
    """Motion over `cycles` cycles above; gait and joint table below."""
    trajectory, steps = solution.trajectory, solution.trajectory.steps_per_cycle
    fig = figure(9.6, 6.4)
    grid = fig.add_gridspec(2, 2, height_ratios=[1.0, 1.55], width_ratios=[1, 1.1])
    top = fig.add_subplot(grid[0, :])
    body = solution.problem.body
    title = f"3 · It crawls {trajectory.displacement:.2f} body lengths per cycle"
    motion(trajectory, top, cycles, 3 * cycles + 1, title, body.total_length_m if body.edge_lengths else None)
    left, right = fig.add_subplot(grid[1, 0]), fig.add_subplot(grid[1, 1])
    gait_curve(solution.gait, left, steps, "1 · The optimal gait in shape space")
    start_label(left, solution.gait)
    shapes_around(solution.gait, shapes(trajectory.poses[:steps], trajectory.vertices[:steps]), left)
    joints.joint_map(solution.table, right, "2 · The joint table the robot plays")
    colour_bar(top, PHASE_MAP, 0, 1, joints.X_LABEL, pad=0.01, aspect=15)
    return fig
