"""Whole figures of a simulation, a solution, a sweep and a multi-start, written as PNG and SVG."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from serpenoid.body import Floats
from serpenoid.files import atomic
from serpenoid.gaits import EllipseGait
from serpenoid.plot import joints, optima
from serpenoid.plot.animate import animation
from serpenoid.plot.body import shapes
from serpenoid.plot.gait import gait_curve, shapes_around, start_label
from serpenoid.plot.motion import motion
from serpenoid.plot.style import PHASE_MAP, colour_bar, figure, legend_above
from serpenoid.plot.sweep import costs_figure, family_figure, front_figure
from serpenoid.problem import Problem
from serpenoid.trajectory import Trajectory

if TYPE_CHECKING:
    from serpenoid.optimise.multistart import MultiStart
    from serpenoid.optimise.solution import Solution
    from serpenoid.plot.family import Family

PIXELS_PER_INCH = 150


def save(fig: Figure, folder: str | Path, name: str) -> list[str]:
    """Write `name`.png and `name`.svg into `folder`, each whole or not at all; returns the file names."""
    names = [f"{name}.png", f"{name}.svg"]
    for file in names:
        with atomic(Path(folder) / file) as temporary:
            metadata = {"Date": None} if file.endswith("svg") else None
            fig.savefig(temporary, dpi=PIXELS_PER_INCH, metadata=metadata)
    return names


def simulation_figures(
    folder: str | Path, problem: Problem, trajectory: Trajectory, table: Floats, gait: EllipseGait | None
) -> list[str]:
    """Gait, motion, joints and animation of one motion; what has no numbers to draw (a failed motion) is left out."""
    names = save(joints_figure(table, problem), folder, "joints")
    if np.isfinite(trajectory.vertices).all():
        names += save(motion_figure(trajectory, problem), folder, "motion")
        if gait is not None:
            names += save(gait_figure(gait, trajectory), folder, "gait")
        cycles = max(2, problem.task.cycles)
        animation(Path(folder) / "animation.gif", trajectory, cycles, problem.task.cycle_duration_s)
        names.append("animation.gif")
    return names


def solution_figures(folder: str | Path, solution: Solution) -> list[str]:
    """The figures of a solution's re-simulated motion."""
    return simulation_figures(folder, solution.problem, solution.trajectory, solution.table, solution.gait)


def sweep_figures(folder: str | Path, data: Family) -> list[str]:
    """The family over c, its Pareto front, its cost of transport; needs two solved gaits or more."""
    family = data.solved()
    if family.c.size < 2:
        return []
    figures = {"family": family_figure, "pareto": front_figure, "cost-of-transport": costs_figure}
    return [file for name, make in figures.items() for file in save(make(family), folder, name)]


def multistart_figures(folder: str | Path, result: MultiStart) -> list[str]:
    """Costs of all starts, and the distinct optima."""
    fig = figure(8.6, 3.4)
    left, right = fig.subplots(1, 2, width_ratios=[3, 2])
    costs, optimum = optima.start_costs(result)
    optima.strip(costs, optimum, left)
    optima.counts(costs, optimum, right)
    return save(fig, folder, "optima")


def gait_figure(gait: EllipseGait, trajectory: Trajectory) -> Figure:
    """Gait curve with the body shapes around it."""
    fig = figure(6.2, 5.4)
    ax = fig.add_subplot()
    steps = trajectory.steps_per_cycle
    gait_curve(gait, ax, steps)
    start_label(ax, gait)
    shapes_around(gait, shapes(trajectory.poses[:steps], trajectory.vertices[:steps]), ax)
    colour_bar(ax, PHASE_MAP, 0, 1, joints.X_LABEL, pad=0.02, aspect=35)
    return fig


def motion_figure(trajectory: Trajectory, problem: Problem, cycles: int | None = None) -> Figure:
    """Bodies along the path, eight moments a cycle or fewer where cycles are many."""
    cycles = cycles or problem.task.cycles
    body = problem.body
    metres = body.total_length_m if body.length_m or body.edge_lengths else None
    fig = figure(8.6, 4.0)
    ax = fig.add_subplot()
    gone, d = trajectory.displacement, trajectory.dissipation
    title = f"{gone:.3f} body lengths per cycle, dissipation {d:.3f}"
    motion(trajectory, ax, cycles, bodies=8 if cycles == 1 else 4 * cycles + 1, title="", body_length_m=metres)
    legend_above(ax, 4)
    fig.suptitle(f"Shapes along the path: {title}", fontsize=10.5, x=0.01, ha="left")
    colour_bar(ax, PHASE_MAP, 0, 1, joints.X_LABEL, pad=0.02, shrink=0.7)
    return fig


def joints_figure(table: Floats, problem: Problem) -> Figure:
    """Joint angles with limits; joint speeds too where the cycle's duration is known."""
    duration, body = problem.task.cycle_duration_s, problem.body
    fig = figure(8.6, 5.6 if duration else 3.2)
    axes = fig.subplots(2 if duration else 1, 1, squeeze=False)[:, 0]
    joints.joint_angles(table, axes[0], body.joint_limit_deg)
    if duration:
        title = f"Joint speeds, a cycle in {duration:g} s"
        joints.joint_speeds(table, axes[1], duration, body.joint_speed_limit_rpm, title)
    joints.joint_bar(list(axes), table.shape[1])
    return fig
