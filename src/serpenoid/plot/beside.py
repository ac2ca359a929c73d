"""Names of levels on the right of a panel, none over another: each with a line to its level."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from serpenoid.body import Floats
from serpenoid.plot.style import GREY, INK, SMALL

LINE = 0.19  # height of a name [inches]


def name_levels(
    levels: Sequence[float] | Floats, words: Sequence[str], ax: Axes, right: float | None = None, colour: str = INK
) -> None:
    """Write each name beside its level, from the place `right` on [of x; default: the panel's edge].

    After all else is drawn: what it finds of the panel's height and limits must stay.
    """
    order = np.argsort(np.asarray(levels), kind="stable")
    low, high = ax.get_ylim()
    left, end = ax.get_xlim()
    edge = 1.0 if right is None else (right - left) / (end - left)
    places = (np.asarray(levels, float)[order] - low) / (high - low)
    height = ax.get_figure(root=True).get_size_inches()[1] - 1.0  # type: ignore[union-attr] # without title, labels
    line: dict[str, Any] = {
        "arrowstyle": "-",
        "color": GREY,
        "linewidth": 0.6,
        "shrinkA": 0,
        "shrinkB": 0,
        "relpos": (0, 0.5),
    }
    for place, at, index in zip(places, apart(places, LINE / height), order, strict=True):
        ax.annotate(
            words[index], (edge, place), xytext=(1.03, at), xycoords="axes fraction", va="center", fontsize=SMALL,
            color=colour, arrowprops=line,
        )  # fmt: skip


def apart(places: Floats, gap: float) -> Floats:
    """Places in [0, 1], rising, moved up and down until they are `gap` apart."""
    moved = np.array(places, dtype=float)
    for i in range(1, moved.size):
        moved[i] = max(moved[i], moved[i - 1] + gap)
    moved[-1:] = np.minimum(moved[-1:], 1.0)
    for i in range(moved.size - 2, -1, -1):
        moved[i] = min(moved[i], moved[i + 1] - gap)
    return moved
