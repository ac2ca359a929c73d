"""What each family of gaits gains over the ellipse, at equal limits and dissipation, and how its body moves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from serpenoid.plot import joints
from serpenoid.plot.body import draw_body
from serpenoid.plot.style import BLUE, GREY, PHASE_MAP, SMALL, colour_bar, dress, figure

if TYPE_CHECKING:
    from serpenoid.optimise.ladder import Step

BODIES = 7


def ladder_figure(steps: Sequence[Step]) -> Figure:
    """Displacement of every family above; bodies along one cycle and the joint table below."""
    fig = figure(2.7 * len(steps) + 0.9, 6.4)
    grid = fig.add_gridspec(3, len(steps), height_ratios=[1.1, 1, 1])
    ax = fig.add_subplot(grid[0, :])
    gone = np.array([step.solution.trajectory.displacement for step in steps])
    ax.bar(range(len(steps)), gone, color=[GREY, *[BLUE] * (len(steps) - 1)], width=0.55)
    for i, value in enumerate(gone):
        gain = "" if i == 0 else f"  ({100 * (value / gone[0] - 1):+.0f} %)"
        ax.annotate(f"{value:.3f}{gain}", (i, value), ha="center", va="bottom", fontsize=SMALL)
    ax.set_xticks(range(len(steps)), [step.name for step in steps])
    ax.margins(y=0.15)
    spent = steps[0].solution.trajectory.dissipation
    dress(ax, f"Displacement at equal limits, dissipation at most {spent:.3f}", "", "body lengths / cycle")
    motions, maps = ([fig.add_subplot(grid[row, i]) for i in range(len(steps))] for row in (1, 2))
    reach = float(max(np.rad2deg(np.abs(step.solution.table)).max() for step in steps)) or 1.0
    for i, (step, motion, below) in enumerate(zip(steps, motions, maps, strict=True)):
        trajectory = step.solution.trajectory
        rows = np.linspace(0, trajectory.steps_per_cycle, BODIES).astype(int)
        for row in rows:
            draw_body(trajectory.vertices[row], motion, PHASE_MAP(row / trajectory.steps_per_cycle), width=1.6)
        motion.set_aspect("equal", adjustable="datalim")
        dress(motion, step.name, "x [body lengths]", "y [body lengths]" if i == 0 else "", grid=False)
        joints.joint_map(step.solution.table, below, "", reach)
        below.set_ylabel("joint, from the tail" if i == 0 else "")
    colour_bar(motions, PHASE_MAP, 0, 1, joints.X_LABEL, pad=0.02, aspect=20)
    joints.angle_bar(maps, reach)
    return fig
