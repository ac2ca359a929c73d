"""Whole figures of a family of gaits over c."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from serpenoid.gaits import EllipseGait
from serpenoid.plot import family as panels
from serpenoid.plot import transport
from serpenoid.plot.family import Family, OneGait
from serpenoid.plot.style import CHAIN_MAP, RED, colour_bar, figure

TITLES = {"sigma": "Flatness", "a": "Amplitude", "xi": "Spatial frequency"}


def family_figure(family: Family) -> Figure:
    """Displacement, dissipation, gait parameters and gait curves against c."""
    fig = figure(9.6, 5.8)
    axes = fig.subplots(2, 3)
    panels.against_c(family, family.displacement, axes[0, 0], panels.DELTA_LABEL, "Displacement")
    panels.against_c(family, family.dissipation, axes[0, 1], panels.D_LABEL, "Dissipation", RED)
    shown = {name: title for name, title in TITLES.items() if name in family.names}
    if family.names != EllipseGait.NAMES:
        axes[0, 2].set_axis_off()
        for ax in axes[1, len(shown) :]:
            ax.set_axis_off()
    else:
        panels.gait_curves(family, axes[0, 2])
        colour_bar(axes[0, 2], CHAIN_MAP, family.c[0], family.c[-1], panels.C_LABEL, pad=0.02, aspect=30)
    for ax, (name, title) in zip(axes[1], shown.items(), strict=False):
        panels.gait_parameters(family, ax, name, title)
    return fig


def front_figure(family: Family, beside: OneGait | None = None) -> Figure:
    """Displacement against dissipation, and a gait beside the family."""
    fig = figure(6.2, 4.4)
    ax = fig.add_subplot()
    panels.pareto(family, ax)
    if beside is not None:
        panels.one_gait(beside, ax)
    ax.legend(frameon=False, fontsize=8, loc="lower right")
    colour_bar(ax, CHAIN_MAP, family.c[0], family.c[-1], panels.C_LABEL, pad=0.02, aspect=35)
    return fig


def costs_figure(family: Family) -> Figure:
    """Cost of transport for a few idle levels, and the level for which each c is best."""
    fig = figure(9.6, 4.0)
    left, right = fig.subplots(1, 2)
    transport.cost_of_transport(family, left, levels(family))
    transport.idle_levels(family, right)
    return fig


def levels(family: Family) -> list[float]:
    """Idle levels worth drawing: none, those that put the least cost at c = 1 and 2, between and beyond them."""
    ends = transport.idle_interval(family)
    low, high = (
        ends if ends and ends[0] > 0 else np.quantile(transport.best_idle(family)[family.c > 0], [0.2, 0.6]).clip(1e-6)
    )
    return [0.0, low / 2, low, float(np.sqrt(low * high)), high, 2 * high]
