"""A gait as a closed curve in the serpenoid shape space (w1, w2), with the body shapes it runs through."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from serpenoid.body import Floats
from serpenoid.gaits import EllipseGait
from serpenoid.plot.body import draw_body
from serpenoid.plot.style import FAINT, GREY, INK, PHASE_MAP, SMALL, dress

FINE = np.linspace(0, 1, 241)
ARROWS = (0.06, 0.56)
X_LABEL, Y_LABEL = r"$w_1$ [rad per body length]", r"$w_2$ [rad per body length]"


def gait_curve(gait: EllipseGait, ax: Axes, rows: int = 50, title: str = "Gait in shape space") -> Axes:
    """The curve, a dot per row of the joint table coloured by its phase, the first row ringed, arrows along time."""
    curve, dots = gait.curve(FINE), gait.curve(np.arange(rows) / rows)
    ax.axhline(0, color=FAINT, linewidth=1, zorder=0.5)
    ax.axvline(0, color=FAINT, linewidth=1, zorder=0.5)
    ax.plot(*curve.T, color=GREY, linewidth=1.2)
    ax.scatter(*dots.T, c=np.arange(rows) / rows, cmap=PHASE_MAP, vmin=0, vmax=1, s=15, linewidths=0, zorder=3)
    ax.plot(*dots[:1].T, "o", markersize=9, markerfacecolor="none", markeredgecolor=INK, markeredgewidth=1.6, zorder=4)
    for phase in ARROWS if gait.a > 0 else ():
        tail, tip = gait.curve(np.array([phase, phase + 0.012]))
        style = {"arrowstyle": "-|>", "color": INK, "mutation_scale": 13, "linewidth": 0}
        ax.annotate("", xy=tuple(tip), xytext=tuple(tail), arrowprops=style, zorder=5)
    ax.set_aspect("equal")
    return dress(ax, title, X_LABEL, Y_LABEL, grid=False)


def shapes_around(gait: EllipseGait, shapes: Floats, ax: Axes) -> Axes:
    """Bodies (T, N, 2), body frame, beside their points of the curve: as many of 8, 6, 4 as fit without overlap."""
    steps, reach = shapes.shape[0], np.ptp(gait.curve(FINE), axis=0).max()
    scale = 0.42 * reach or 1.0
    for count in (8, 6, 4):
        rows = np.arange(count) * steps // count
        places = [_place(gait, row / steps, scale * shapes[row], 0.05 * reach) for row in rows]
        if not _overlap(np.array([(p.min(0), p.max(0)) for p in places])):
            break
    for row, points in zip(rows, places, strict=True):
        anchor, middle = gait.curve(np.array([row / steps]))[0], (points.min(0) + points.max(0)) / 2
        ax.plot(*np.stack([anchor, middle]).T, color=GREY, linewidth=0.6, linestyle=":", zorder=1)
        draw_body(points, ax, PHASE_MAP(row / steps), width=2.2, joints=False)
    corner = np.concatenate([*places, gait.curve(FINE)])
    pad = 0.04 * np.ptp(corner, axis=0).max() or 1.0
    ax.set_xlim(corner[:, 0].min() - pad, corner[:, 0].max() + pad)
    ax.set_ylim(corner[:, 1].min() - pad, corner[:, 1].max() + pad)
    return ax


def start_label(ax: Axes, gait: EllipseGait) -> Axes:
    """Names the first row, towards the middle of the curve where nothing else is drawn."""
    start, centre = gait.curve(np.zeros(1))[0], np.array([gait.x_c, gait.y_c])
    inward = (centre - start) / (np.linalg.norm(centre - start) or 1.0)
    side = "left" if inward[0] >= 0 else "right"
    ax.annotate(
        "start", tuple(start), xytext=tuple(12 * inward), textcoords="offset points", ha=side, va="center",
        fontsize=SMALL, color=INK,
    )  # fmt: skip
    return ax


def _place(gait: EllipseGait, phase: float, body: Floats, gap: float) -> Floats:
    """The body moved off its point along the curve's outward normal, until its box clears the tangent."""
    before, point, after = gait.curve(np.array([phase - 1e-4, phase, phase + 1e-4]))
    tangent = after - before
    normal = np.array([tangent[1], -tangent[0]]) * (1 if gait.sigma >= 0 else -1)
    normal = normal / np.linalg.norm(normal) if normal.any() else np.array([0.0, 1.0])
    half = np.ptp(body, axis=0) / 2
    centred = body - (body.max(0) + body.min(0)) / 2
    return centred + point + normal * (np.abs(normal) @ half + gap)


def _overlap(boxes: Floats) -> bool:
    """Whether any two boxes (n, 2 ends, 2) overlap."""
    low, high = boxes[:, 0], boxes[:, 1]
    apart = ((low[:, None] > high[None]) | (high[:, None] < low[None])).any(-1)
    return bool((~apart).sum() > len(boxes))
