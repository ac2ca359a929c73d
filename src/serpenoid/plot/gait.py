"""A gait as a closed curve in the serpenoid shape space (w1, w2), with the body shapes it runs through."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from serpenoid.body import Floats
from serpenoid.gaits import Gait
from serpenoid.plot.body import draw_body
from serpenoid.plot.style import FAINT, GREY, INK, PHASE_MAP, SMALL, dress, fill_equal

FINE = np.linspace(0, 1, 241)
ARROWS = (0.06, 0.56)
X_LABEL, Y_LABEL = r"$w_1$ [rad per body length]", r"$w_2$ [rad per body length]"


def curve_of(gait: Gait, phases: Floats) -> Floats:
    """Points (n, 2) of a gait that is a curve in this space."""
    curve = gait.curve(phases)
    if curve is None:
        raise ValueError(f"a gait of the family `{gait.family}` is no curve in the serpenoid shape space")
    return curve


def signed_area(curve: Floats) -> float:
    """Area that a closed curve (n, 2) encloses, positive counter-clockwise."""
    x, y = curve.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def gait_curve(gait: Gait, ax: Axes, rows: int = 50, title: str = "Gait in shape space") -> Axes:
    """The curve, a dot per row of the joint table coloured by its phase, the first row ringed, arrows along time."""
    curve, dots = curve_of(gait, FINE), curve_of(gait, np.arange(rows) / rows)
    ax.axhline(0, color=FAINT, linewidth=1, zorder=0.5)
    ax.axvline(0, color=FAINT, linewidth=1, zorder=0.5)
    ax.plot(*curve.T, color=GREY, linewidth=1.2)
    ax.scatter(
        dots[:, 0], dots[:, 1], c=np.arange(rows) / rows, cmap=PHASE_MAP, vmin=0, vmax=1, s=15, linewidths=0, zorder=3
    )
    ax.plot(*dots[:1].T, "o", markersize=9, markerfacecolor="none", markeredgecolor=INK, markeredgewidth=1.6, zorder=4)
    for phase in ARROWS if np.ptp(curve, axis=0).any() else ():
        tail, tip = curve_of(gait, np.array([phase, phase + 0.03]))
        style = {"arrowstyle": "-|>", "color": INK, "mutation_scale": 17, "linewidth": 0, "shrinkA": 0, "shrinkB": 0}
        ax.annotate("", xy=tuple(tip), xytext=tuple(tail), arrowprops=style, zorder=5)
    fill_equal(ax)
    return dress(ax, title, X_LABEL, Y_LABEL, grid=False)


def shapes_around(gait: Gait, shapes: Floats, ax: Axes) -> Axes:
    """Bodies (T, N, 2), body frame, beside their points of the curve: as many of 8, 6, 4 as fit without overlap."""
    steps, reach = shapes.shape[0], np.ptp(curve_of(gait, FINE), axis=0).max() or 1.0
    scale = 0.42 * reach
    for count in (8, 6, 4):
        rows = np.arange(count) * steps // count
        places = [_place(gait, row / steps, scale * shapes[row], 0.05 * reach) for row in rows]
        if not _overlap(np.array([(p.min(0), p.max(0)) for p in places])):
            break
    for row, points in zip(rows, places, strict=True):
        anchor = curve_of(gait, np.array([row / steps]))[0]
        nearest = points[np.linalg.norm(points - anchor, axis=1).argmin()]
        ax.plot(*np.stack([anchor, nearest]).T, color=GREY, linewidth=0.8, linestyle=":", zorder=1)
        draw_body(points, ax, PHASE_MAP(row / steps), width=2.6)
    return ax


def start_label(ax: Axes, gait: Gait) -> Axes:
    """Names the first row, towards the middle of the curve where nothing else is drawn."""
    start, inward = curve_of(gait, np.zeros(1))[0], -_normal(gait, 0.0)
    side = "left" if inward[0] > 0.3 else "right" if inward[0] < -0.3 else "center"
    ax.annotate(
        "start", tuple(start), xytext=tuple(12 * inward), textcoords="offset points", ha=side, va="center",
        fontsize=SMALL, color=INK,
    )  # fmt: skip
    return ax


def _place(gait: Gait, phase: float, body: Floats, gap: float) -> Floats:
    """The body moved off its point along the curve's outward normal, until its box clears the tangent."""
    point, normal = curve_of(gait, np.array([phase]))[0], _normal(gait, phase)
    half = np.ptp(body, axis=0) / 2
    centred = body - (body.max(0) + body.min(0)) / 2
    return centred + point + normal * (np.abs(normal) @ half + gap)


def _normal(gait: Gait, phase: float) -> Floats:
    """Outward unit normal of the curve; upright where the curve is a point."""
    before, after = curve_of(gait, np.array([phase - 1e-4, phase + 1e-4]))
    normal = np.array([after[1] - before[1], before[0] - after[0]]) * (
        1 if signed_area(curve_of(gait, FINE)) >= 0 else -1
    )
    size = np.linalg.norm(normal)
    return normal / size if size > 1e-12 else np.array([0.0, 1.0])


def _overlap(boxes: Floats) -> bool:
    """Whether any two boxes (n, 2 ends, 2) overlap."""
    low, high = boxes[:, 0], boxes[:, 1]
    apart = ((low[:, None] > high[None]) | (high[:, None] < low[None])).any(-1)
    return bool((~apart).sum() > len(boxes))
