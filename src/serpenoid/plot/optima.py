"""A multi-start at a glance: where each start ended, which distinct optima there are and how often each was found."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from serpenoid.body import Floats
from serpenoid.plot.beside import LINE, name_levels
from serpenoid.plot.style import BLUE, CHAIN_MAP, RED, dress, figure, legend_above

if TYPE_CHECKING:
    from serpenoid.optimise.multistart import MultiStart

COST_LABEL = "cost (the objective)"
SHOWN = 12  # optima named one by one


def optima_figure(result: MultiStart) -> Figure:
    """As high as the names of the optima need."""
    costs, optimum = start_costs(result)
    fig = figure(8.6, max(2.6, 1.5 + LINE * min(optimum.max(initial=-1) + 1, SHOWN + 1)))
    strip(costs, optimum, fig.add_subplot())
    return fig


def start_costs(result: MultiStart) -> tuple[Floats, np.ndarray]:
    """Cost of each start's answer and the number of its optimum (0 the best, -1 a failure), both (S,)."""
    costs = np.array([s.cost for s in result.solutions])
    levels = np.array([o.solution.cost for o in result.optima])
    nearest = np.abs(costs[:, None] - levels[None]).argmin(1) if levels.size else np.full(costs.size, -1)
    return costs, np.where([s.status.ok for s in result.solutions], nearest, -1)


def strip(costs: Floats, optimum: np.ndarray, ax: Axes) -> Axes:
    """A dot per start, with the distinct optima's names; failures are crosses, at the top where they have no cost."""
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
        level = float(costs[known].max())
        ax.set_ylim(level - 0.05, level + 0.05)
        ax.set_yticks([level], [f"{level:.4g}".replace("-", "−")])
    ax.set_xlim(0.4, costs.size + 0.6)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    count = int(optimum.max(initial=-1)) + 1
    title = f"Cost reached from each start: {count} distinct optim{'um' if count == 1 else 'a'}"
    dress(ax, title, "start [number]", COST_LABEL)
    _name_optima(costs, optimum, ax)
    if not ok.all():
        legend_above(ax, 1)
    return ax


def names(costs: Floats, optimum: np.ndarray) -> tuple[list[float], list[str]]:
    """Level of each distinct optimum, the best first, and in words: its cost, and how many starts ended there."""
    found = int(optimum.max(initial=-1)) + 1
    levels = [float(costs[optimum == k].min()) for k in range(min(found, SHOWN))]
    words = [f"{level:.6f}: {(optimum == k).sum()} of {costs.size}" for k, level in enumerate(levels)]
    if found > SHOWN:
        levels.append(float(costs[optimum == SHOWN].min()))
        words.append(f"{found - SHOWN} more: {(optimum >= SHOWN).sum()} of {costs.size}")
    return levels, [text.replace("-", "−") for text in words]


def _name_optima(costs: Floats, optimum: np.ndarray, ax: Axes) -> None:
    """Beside their levels, on the right."""
    levels, words = names(costs, optimum)
    name_levels(levels, words, ax)


def _colours(optimum: np.ndarray) -> Floats:
    """A colour per optimum, the best darkest."""
    found = int(optimum.max(initial=0)) + 1
    return CHAIN_MAP(np.linspace(0.15, 0.95, found)) if found > 1 else CHAIN_MAP([0.25])
