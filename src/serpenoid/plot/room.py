"""Places for a grid of axes with numbers and short names beside them, whose width is known from how many letters they
have: an engine that measures each of them, twice, takes as long as to draw them."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure

from serpenoid.plot.style import SMALL

INCH = 72.0  # points
DIGIT = 0.65 * SMALL / INCH  # a number's letter at most, but for a minus [inches], DejaVu Sans
WIDE = "\N{MINUS SIGN}mw"  # and capitals: up to half as much again
LETTERS = 1.4 * SMALL / INCH  # height of a line of them
GAP = 0.12  # tick, its distance from the number, and what stays free
FEWEST = 4  # letters of a number: axes of equal scales find theirs as they are drawn


def settle(fig: Figure, grid: Any, above: float = 0.0, title: float = 0.0, right: float = 0.1) -> None:
    """Fill the figure with axes (R, C) and what stands beside and below them.

    above: room over the grid, title: over each row, right: of the grid [inches].
    """
    fig.set_layout_engine("none")
    axes = np.atleast_2d(grid)
    width, height = fig.get_size_inches()
    left = np.array([max(room(ax, ax.yaxis) for ax in column) for column in axes.T])
    below = np.array([max(room(ax, ax.xaxis) for ax in row) for row in axes])
    wide = (width - right - left.sum()) / axes.shape[1]
    high = (height - above - below.sum() - title * len(axes)) / len(axes)
    for r, row in enumerate(axes):
        foot = height - above - (r + 1) * (title + high) - below[:r].sum()
        for c, ax in enumerate(row):
            start = left[: c + 1].sum() + c * wide
            ax.set_position((start / width, foot / height, wide / width, high / height))


def room(ax: Axes, axis: Axis) -> float:
    """What an axis' numbers and its name take [inches]."""
    upright = axis is ax.yaxis
    found = GAP + LETTERS * bool(axis.get_label_text()) * (1.2 if upright else 1.4)
    if not ax.axison or not axis.get_tick_params()["labelleft" if upright else "labelbottom"]:
        return found + 2 * DIGIT * upright  # the numbers below panels reach half beyond their ends
    if not upright:
        return found + LETTERS * (1 + max(text.count("\n") for text in labels(axis)))
    return found + DIGIT * max(FEWEST, *(len(t) + 0.5 * sum(c in WIDE or c.isupper() for c in t) for t in labels(axis)))


def labels(axis: Axis) -> list[str]:
    """Of its ticks."""
    return axis.get_major_formatter().format_ticks(list(axis.get_majorticklocs())) or [""]
