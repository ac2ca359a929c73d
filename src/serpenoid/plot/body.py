"""One body: its chain, with the head marked.

Legend: N vertices (tail first), R rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from serpenoid import group
from serpenoid.body import Floats

Artists = tuple[Line2D, Line2D, Line2D]
ZORDER = 2


def draw_body(vertices: Floats, ax: Axes, colour: Any, width: float = 3.4, joints: Sequence[int] = ()) -> Artists:
    """Rim, chain (N, 2) with white dots at `joints` (vertex numbers), and round head.

    The white rim keeps crossing bodies apart; heads lie over all chains.
    """
    shown: dict[str, Any] = {"solid_capstyle": "round", "solid_joinstyle": "round", "zorder": ZORDER}
    (rim,) = ax.plot(*vertices.T, color="white", linewidth=width + 1.6, **shown)
    (chain,) = ax.plot(
        *vertices.T, color=colour, linewidth=width, marker="o" if joints else None, markevery=list(joints) or None,
        markersize=0.7 * width, markerfacecolor="white", markeredgewidth=0, **shown,
    )  # fmt: skip
    (head,) = ax.plot(
        *vertices[-1:].T, "o", markersize=2.4 * width, color=colour, markeredgecolor="white", markeredgewidth=0.9,
        zorder=ZORDER + 0.5,
    )  # fmt: skip
    return rim, chain, head


def move_body(artists: Artists, vertices: Floats) -> None:
    """Put a drawn body elsewhere."""
    rim, chain, head = artists
    rim.set_data(*vertices.T)
    chain.set_data(*vertices.T)
    head.set_data(*vertices[-1:].T)


def shapes(poses: Floats, vertices: Floats) -> Floats:
    """Chains (R, N, 2) of a motion in their body frames: centroid at the origin, heading along the first axis."""
    turned = group.rotation(poses[:, 2])
    return np.einsum("rji,rnj->rni", turned, vertices - poses[:, None, :2])
