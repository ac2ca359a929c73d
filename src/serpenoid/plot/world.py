"""Obstacles and walls of a task, as shaded regions where the body may not be."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from serpenoid.objectives.obstacles import Obstacle
from serpenoid.plot.style import GREY
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
