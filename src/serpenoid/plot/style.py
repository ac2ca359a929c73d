"""One look for every picture: colours that the colour-blind tell apart (Okabe and Ito 2008), sizes, labels.

Nothing here touches matplotlib's global state, so figures can be made in threads.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.colors import Colormap, ListedColormap, Normalize, to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

BLUE, ORANGE, GREEN, RED, PURPLE = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7"
INK, GREY, FAINT = "#222222", "#7F7F7F", "#E4E4E4"
SMALL, NORMAL, LARGE = 8.0, 9.0, 10.5
Colour = tuple[float, float, float]


def _cut(name: str, low: float, high: float) -> Colormap:
    """Part of a colour map whose lightness grows steadily, without the ends that vanish on white."""
    return ListedColormap(colormaps[name](np.linspace(low, high, 256)), name=f"{name}-cut")


PHASE_MAP = _cut("plasma", 0.0, 0.86)  # phase within the cycle
CHAIN_MAP = _cut("viridis", 0.0, 0.84)  # place along the body, or the coefficient c
ANGLE_MAP = colormaps["PuOr_r"]  # signed angles


PAD = 0.05  # of the extent of what is drawn, about it
PALEST = 0.65  # of the way to white: still seen on it


def in_turn(colour: str, index: int, count: int) -> Colour:
    """The colour of one of `count` alike: the first as it is, the others paler and paler."""
    share = PALEST * index / max(count - 1, 1)
    red, green, blue = ((1 - share) * part + share for part in to_rgb(colour))
    return red, green, blue


def figure(width: float, height: float) -> Figure:
    """An empty white figure of `width` x `height` inches that lays its axes out without overlaps."""
    return Figure(figsize=(width, height), layout="constrained", facecolor="white")


def dress(ax: Axes, title: str, x: str, y: str, grid: bool = True) -> Axes:
    """Title (in lines as wide as the figure), axis labels (with units), light grid, no box."""
    if title:
        ax.set_title(title, fontsize=LARGE, loc="left", color=INK, wrap=True)
    ax.set_xlabel(x, fontsize=NORMAL, color=INK)
    ax.set_ylabel(y, fontsize=NORMAL, color=INK)
    ax.tick_params(labelsize=SMALL, color=GREY, labelcolor=INK)
    ax.spines[["top", "right"]].set_visible(False)
    ax.spines[["left", "bottom"]].set_color(GREY)
    if grid:
        ax.grid(color=FAINT, linewidth=0.7)
    ax.set_axisbelow(True)
    return ax


def legend_above(ax: Axes, columns: int) -> None:
    """Legend in lines of so many entries between title and axes, where no data can be."""
    lines = -(-len(ax.get_legend_handles_labels()[1]) // columns)
    ax.set_title(ax.get_title(loc="left"), fontsize=LARGE, loc="left", color=INK, pad=8 + 14 * lines)
    ax.legend(
        loc="lower left", bbox_to_anchor=(-0.01, 1.0), ncols=columns, frameon=False, fontsize=SMALL,
        borderaxespad=0.1, handletextpad=0.5, columnspacing=1.4,
    )  # fmt: skip


def around(points: NDArray[np.float64], ax: Axes, below: float = 0.0) -> float:
    """Equal axes round points (n, 2), with PAD of their extent around and `below` more under it; height / width."""
    low, high = points.min(0), points.max(0)
    extent = float((high - low).max()) or 1.0
    x = low[0] - PAD * extent, high[0] + PAD * extent
    y = low[1] - (PAD + below) * extent, high[1] + PAD * extent
    ax.set(xlim=x, ylim=y, aspect="equal")
    _few_ticks(ax)
    return (y[1] - y[0]) / (x[1] - x[0])


def fill_equal(ax: Axes) -> None:
    """Equal axes that show all data and fill their place by showing more on one side."""
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.05)
    _few_ticks(ax)


def _few_ticks(ax: Axes) -> None:
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MaxNLocator(nbins=7, steps=[1, 2, 5, 10]))


def colour_bar(
    ax: Axes | Sequence[Axes], colours: Colormap, low: float, high: float, label: str, **options: Any
) -> Colorbar:
    """Colour bar beside `ax` for numbers from `low` to `high`."""
    shown = ScalarMappable(Normalize(low, high), colours)
    first = ax if isinstance(ax, Axes) else ax[0]
    bar = first.get_figure(root=True).colorbar(shown, ax=ax, **options)  # type: ignore[union-attr]
    bar.set_label(label, fontsize=NORMAL, color=INK)
    bar.ax.tick_params(labelsize=SMALL, color=GREY, labelcolor=INK)
    bar.outline.set_visible(False)
    return bar
