"""The README's picture: the motion of an optimal gait, its curve in shape space, and its joint table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from serpenoid.plot import joints
from serpenoid.plot.body import shapes
from serpenoid.plot.gait import gait_curve, shapes_around, start_label
from serpenoid.plot.motion import motion
from serpenoid.plot.style import PHASE_MAP, colour_bar, figure, legend_above

if TYPE_CHECKING:
    from serpenoid.optimise.solution import Solution

WIDTH, BELOW = 9.6, 3.7  # inches


def hero(solution: Solution, cycles: int = 3) -> Figure:
    """Motion over `cycles` cycles above; gait and joint table below."""
    trajectory, steps = solution.trajectory, solution.trajectory.steps_per_cycle
    fig = figure(WIDTH, 2 * BELOW)
    grid = fig.add_gridspec(2, 2, width_ratios=[1.06, 1])
    top, left, right = (fig.add_subplot(grid[part]) for part in ((0, slice(None)), (1, 0), (1, 1)))
    body, gone = solution.problem.body, trajectory.displacement
    title = f"An optimal gait: {gone:.2f} body lengths per cycle, {cycles} cycles"
    motion(trajectory, top, cycles, 3 * cycles + 1, title, body.total_length_m if body.edge_lengths else None)
    legend_above(top, 4)
    gait_curve(solution.gait, left, steps, "Its curve in the space of body shapes")
    start_label(left, solution.gait)
    shapes_around(solution.gait, shapes(trajectory.poses[:steps], trajectory.vertices[:steps]), left)
    colour_bar(left, PHASE_MAP, 0, 1, joints.X_LABEL, pad=0.02, aspect=30)
    joints.joint_map(solution.table, right, "Its joint table, ready to play")
    slope = float(np.ptp(top.get_ylim()) / np.ptp(top.get_xlim()))
    above = (WIDTH - 0.9) * min(slope, 0.5) + 0.95
    grid.set_height_ratios([above, BELOW])
    fig.set_size_inches(WIDTH, above + BELOW)
    return fig
