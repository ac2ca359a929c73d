"""One body: its chain, with the head marked.

Legend: N vertices (tail first), R rows.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patheffects import Normal, Stroke

from serpenoid import group
from serpenoid.body import Floats


def draw_body(vertices: Floats, ax: Axes, colour: Any, width: float = 3.0, joints: bool = True) -> tuple[Line2D, Line2D]:
    """Chain (N, 2) with white dots at its joints and a round head; a white rim keeps crossing bodies apart."""
    (chain,) = ax.plot(
        *vertices.T, color=colour, linewidth=width, solid_capstyle="round", solid_joinstyle="round",
        marker="o" if joints else None, markersize=0.45 * width, markerfacecolor="white", markeredgewidth=0,
    )  # fmt: skip
    chain.set_path_effects([Stroke(linewidth=width + 1.6, foreground="white"), Normal()])
    (head,) = ax.plot(
        *vertices[-1:].T, marker="o", markersize=2.3 * width, color=colour, markeredgecolor="white", markeredgewidth=0.8
    )
    return chain, head


def shapes(poses: Floats, vertices: Floats) -> Floats:
    """Chains (R, N, 2) of a motion in their body frames: centroid at the origin, heading along the first axis."""
    turned = group.rotation(poses[:, 2])
    return np.einsum("rji,rnj->rni", turned, vertices - poses[:, None, :2])
