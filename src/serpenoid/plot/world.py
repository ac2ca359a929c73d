"""The world of a task: places to reach; obstacles and walls, as shaded regions where the body may not be."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from serpenoid.objectives.obstacles import Obstacle
from serpenoid.objectives.path import Path
from serpenoid.objectives.position import Position
from serpenoid.objectives.reach import Reach
from serpenoid.plot.style import GREY, RED
from serpenoid.problem import Problem

GRID = 240


def obstacles(problem: Problem, ax: Axes) -> Axes:
    """Shade what is forbidden within the present limits of the axes."""
    found = [demand for demand in problem.task.demands if isinstance(demand, Obstacle)]
    if not found:
        return ax
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    x, y = np.meshgrid(np.linspace(left, right, GRID), np.linspace(low, high, GRID))
    points = np.column_stack([x.ravel(), y.ravel()])
    value = np.min([obstacle.gap(points) for obstacle in found], axis=0).reshape(x.shape)
    if value.min() < 0:
        ax.contourf(x, y, value, levels=[-1e9, 0], colors=[GREY], alpha=0.35, zorder=0)
        ax.contour(x, y, value, levels=[0], colors=[GREY], linewidths=1.0, zorder=0.2)
    return ax


def cycles_asked(problem: Problem) -> int:
    """Cycles until all that is asked for has been reached: those of the task, or more where a goal counts more."""
    asked = [*problem.task.objectives, *problem.task.demands]
    return max([problem.task.cycles, *(getattr(goal, "cycles", 1) for goal in asked)])


def targets(problem: Problem, ax: Axes) -> Axes:
    """Mark what is asked for: a place by a cross, in a circle where being near is enough; a line to follow, dashed."""
    asked = [*problem.task.objectives, *problem.task.demands]
    for index, goal in enumerate(goal for goal in asked if isinstance(goal, Position | Reach)):
        ax.plot(*goal.target, "x", color=RED, markersize=9, zorder=6, label="" if index else "target")
        if isinstance(goal, Reach) and goal.radius > 0:
            ax.add_patch(Circle(goal.target, goal.radius, fill=False, edgecolor=RED, linewidth=1.0, zorder=6))
    for way in (goal for goal in asked if isinstance(goal, Path)):
        ax.plot(*np.array(way.line).T, "--", color=RED, linewidth=1.0, zorder=5, label=f"line of the {way.point}")
    return ax
