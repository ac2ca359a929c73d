"""A multi-start at a glance: where each start ended, which distinct optima there are and how often each was found."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from serpenoid.body import Floats
from serpenoid.plot.style import BLUE, CHAIN_MAP, GREY, INK, RED, SMALL, dress, legend_above

if TYPE_CHECKING:
    from serpenoid.optimise.multistart import MultiStart

COST_LABEL = "cost (the objective)"
SHOWN = 12  # optima named one by one


def start_costs(result: MultiStart) -> tuple[Floats, np.ndarray]:
    """Cost of each start's answer and the number of its optimum (0 the best, -1 a failure), both (S,)."""
    costs = np.array([s.cost for s in result.solutions])
    levels = np.array([o.solution.cost for o in result.optima])
    nearest = np.abs(costs[:, None] - levels[None]).argmin(1) if levels.size else np.full(costs.size, -1)
    return costs, np.where([s.status.ok for s in result.solutions], nearest, -1)


def strip(costs: Floats, optimum: np.ndarray, ax: Axes, title: str = "Cost reached from each start") -> Axes:
    """A dot per start; failures are crosses, at the top where they have no cost."""
    ok = optimum >= 0
    starts = np.arange(1, costs.size + 1)
    known = np.isfinite(costs)
    if ok.any():
        ax.axhline(costs[ok].min(), color=BLUE, linewidth=1, linestyle="--")
        ax.scatter(starts[ok], costs[ok], c=_colours(optimum)[optimum[ok]], s=34, linewidths=0, zorder=3)
    if not ok.all():
        cross: dict[str, Any] = {"color": RED, "markersize": 7, "zorder": 4, "clip_on": False}
        ax.plot(starts[~ok & known], costs[~ok & known], "x", label=f"failed ({(~ok).sum()})", **cross)
        ax.plot(starts[~known], np.ones((~known).sum()), "x", transform=ax.get_xaxis_transform(), **cross)
    if known.any() and np.ptp(costs[known]) < 1e-6:  # one optimum: do not magnify rounding errors into a pattern
        ax.set_ylim(costs[known].max() - 0.05, costs[known].max() + 0.05)
    ax.set_xlim(0.4, costs.size + 0.6)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    dress(ax, title, "start [number]", COST_LABEL)
    if not ok.all():
        legend_above(ax, 1)
    return ax


def counts(costs: Floats, optimum: np.ndarray, ax: Axes, title: str = "Distinct optima") -> Axes:
    """A bar per distinct optimum, the best on top, with its count; failures last."""
    found = int(optimum.max(initial=-1)) + 1
    names, sizes, colours = [], [], []
    for k in range(min(found, SHOWN)):
        names.append(f"{costs[optimum == k].min():.6f}".replace("-", "−"))
        sizes.append(int((optimum == k).sum()))
        colours.append(_colours(optimum)[k])
    for name, size in ((f"{found - SHOWN} more", int((optimum >= SHOWN).sum())), ("failed", int((optimum < 0).sum()))):
        if size:
            names.append(name)
            sizes.append(size)
            colours.append(GREY if name != "failed" else RED)
    bars = ax.barh(np.arange(len(names)), sizes, color=colours, height=0.6)
    ax.bar_label(bars, [f"{size} of {costs.size}" for size in sizes], padding=4, fontsize=SMALL, color=INK)
    ax.set_yticks(np.arange(len(names)), names)
    ax.set_ylim(max(len(names), 3) - 0.4, -0.6)
    ax.set_xlim(0, 1.25 * max(sizes, default=1))
    ax.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    dress(ax, title, "starts [count]", COST_LABEL)
    ax.yaxis.grid(False)
    return ax


def _colours(optimum: np.ndarray) -> Floats:
    """A colour per optimum, the best darkest."""
    found = int(optimum.max(initial=0)) + 1
    return CHAIN_MAP(np.linspace(0.15, 0.95, found)) if found > 1 else CHAIN_MAP([0.25])
