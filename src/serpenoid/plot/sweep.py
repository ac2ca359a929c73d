"""Whole figures of a family of gaits over c."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from serpenoid.plot import family as panels
from serpenoid.plot.family import Family
from serpenoid.plot.style import CHAIN_MAP, RED, colour_bar, figure


def family_figure(family: Family) -> Figure:
    """Displacement, dissipation, gait parameters and gait curves against c."""
    fig = figure(9.6, 5.8)
    axes = fig.subplots(2, 3)
    panels.against_c(family, family.displacement, axes[0, 0], panels.DELTA_LABEL, "Displacement")
    panels.against_c(family, family.dissipation, axes[0, 1], panels.D_LABEL, "Dissipation", RED)
    panels.gait_curves(family, axes[0, 2])
    colour_bar(axes[0, 2], CHAIN_MAP, family.c[0], family.c[-1], "c", pad=0.02, aspect=30)
    for ax, name in zip(axes[1], ("sigma", "a", "xi"), strict=True):
        panels.gait_parameters(family, ax, name)
    return fig


def front_figure(family: Family) -> Figure:
    """Displacement against dissipation."""
    fig = figure(6.2, 4.4)
    ax = fig.add_subplot()
    panels.pareto(family, ax)
    ax.legend(frameon=False, fontsize=8, loc="lower right")
    colour_bar(ax, CHAIN_MAP, family.c[0], family.c[-1], panels.C_LABEL, pad=0.02, aspect=35)
    return fig


def costs_figure(family: Family) -> Figure:
    """Cost of transport for a few idle levels, and the level for which each c is best."""
    fig = figure(9.6, 4.0)
    left, right = fig.subplots(1, 2)
    panels.cost_of_transport(family, left, levels(family))
    panels.idle_levels(family, right)
    return fig


def levels(family: Family) -> list[float]:
    """Idle levels worth drawing: none, both ends and the middle of those that put the least cost at 1 < c < 2, and more."""
    ends = panels.idle_interval(family) or tuple(np.quantile(family.best_idle[family.c > 0], [0.1, 0.6]))
    low, high = ends
    return [0.0, low / 2, low, float(np.sqrt(low * high)), high, 2 * high]
