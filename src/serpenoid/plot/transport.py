"""Cost of transport over the family of gaits, and the idle level for which each gait is the best.

A gait that minimises -Delta + c D has Delta' = c D' along the family. Its cost of transport (p + D) / Delta, with p the
idle energy of a cycle in the units of D, is therefore stationary where p = Delta / c - D: each c is the best for one
idle level p, and p falls as c grows (its slope is -Delta / c^2: the other terms cancel).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from serpenoid.body import Floats
from serpenoid.performance import idle_for_minimum, normalised_cost_of_transport
from serpenoid.plot.beside import name_levels
from serpenoid.plot.family import C_LABEL, Family
from serpenoid.plot.style import BLUE, CHAIN_MAP, GREY, INK, NORMAL, ORANGE, dress, legend_above

P_LABEL = "idle energy per cycle p [units of D]"
BETWEEN = (1.0, 2.0)  # where the paper's robot had its least cost of transport


def best_idle(family: Family) -> Floats:
    """The idle level p at which each gait has the least cost of transport, inf at c = 0; shape (n,)."""
    with np.errstate(divide="ignore"):
        return np.where(family.c > 0, family.displacement / family.c, np.inf) - family.dissipation


def idle_interval(family: Family) -> tuple[float, float] | None:
    """Idle levels (lower, upper) whose least cost lies at a c BETWEEN two; None if the sweep is shorter than that."""
    return idle_for_minimum(family.c, family.displacement, family.dissipation, *BETWEEN)


def cost_of_transport(family: Family, ax: Axes, idle_levels: Sequence[float]) -> Axes:
    """A curve per idle level p, a dot per gait, the least of these starred (hollow at an end: it goes on beyond)."""
    along = family.between()
    ends = []
    for p, colour in zip(idle_levels, CHAIN_MAP(np.linspace(0, 1, len(idle_levels))), strict=True):
        cost = normalised_cost_of_transport(family.displacement, family.dissipation, p)
        curve = normalised_cost_of_transport(along.displacement, along.dissipation, p)
        least = int(curve.argmin())
        inside = 0 < least < along.c.size - 1
        star: dict[str, Any] = {"color": colour, "markerfacecolor": colour if inside else "white"}
        ax.plot(along.c, curve, color=colour, linewidth=1.6)
        ax.plot(family.c, cost, "o", color=colour, markersize=3)
        ax.plot(along.c[least], curve[least], "*", markersize=12, markeredgecolor=colour, zorder=4, **star)
        ends.append(cost[-1])
    ax.plot([], [], "*", color=GREY, markersize=10, label="least cost")
    ax.plot([], [], "*", color=GREY, markersize=10, markerfacecolor="white", label="least at an end of the sweep")
    ax.set_ylim(0, None)
    if idle_interval(family) is not None:
        ax.axvspan(*BETWEEN, color=ORANGE, alpha=0.15, linewidth=0, zorder=0)
    dress(ax, "Cost of transport (p + D) / Δ", C_LABEL, "cost of transport [units of D / body length]")
    name_levels(ends, [f"p = {p:.3g}" for p in idle_levels], ax, family.c[-1])
    legend_above(ax, 2)
    return ax


def idle_levels(family: Family, ax: Axes) -> Axes:
    """For each c the idle level it is best for; levels whose least cost lies at a c BETWEEN two are shaded."""
    real = family.c > 0
    along = family.between(int(np.argmax(real)))
    ax.semilogy(along.c, best_idle(along), color=BLUE, linewidth=1.5)
    ax.semilogy(family.c[real], best_idle(family)[real], "o", color=BLUE, markersize=4)
    ends = idle_interval(family)
    if ends is not None:
        ax.axhspan(*ends, color=ORANGE, alpha=0.25, linewidth=0)
        ax.vlines(BETWEEN, 0, 1, transform=ax.get_xaxis_transform(), color=GREY, linewidth=1, linestyle="--")
        ax.text(
            0.97, 0.95, f"least cost at {BETWEEN[0]:g} < c < {BETWEEN[1]:g}\nfor {ends[0]:.3f} < p < {ends[1]:.3f}",
            transform=ax.transAxes, ha="right", va="top", fontsize=NORMAL, color=INK,
            bbox={"facecolor": "white", "linewidth": 0, "pad": 3},
        )  # fmt: skip
    ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    ax.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    ax.yaxis.set_minor_formatter(NullFormatter())
    return dress(ax, "The idle level for which each c is best: p = Δ/c − D", C_LABEL, P_LABEL)
