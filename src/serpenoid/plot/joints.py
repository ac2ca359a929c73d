"""Joint angles and joint speeds of a joint table over the cycle, with the limits they must keep.

Legend: T rows, m joints; the row after the last is the first again, but not of a transient motion.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import ListedColormap
from matplotlib.ticker import MaxNLocator

from serpenoid.body import Floats
from serpenoid.joint_range import Limit, limit_words, of_each, ranges_deg
from serpenoid.plot.style import ANGLE_MAP, CHAIN_MAP, GREY, RED, SMALL, colour_bar, dress

X_LABEL, ONCE = "phase [cycles]", "time [share of the motion]"
SHADES = 256  # matplotlib draws a bar of a few as patches
FAR = 2.0  # times the data: a limit beyond would take more than half of the picture


def joint_colours(count: int) -> Floats:
    """A colour for each joint from tail to head, shape (m, 4)."""
    return CHAIN_MAP(np.arange(count) / max(count - 1, 1))


def joint_angles(
    table: Floats, ax: Axes, limit_deg: Limit | None = None, title: str = "Joint angles", closed: bool = True
) -> Axes:
    """A line per joint, (T, m) [rad], closed at phase 1 (a transient ends there with its last row); limits dashed.

    A limit that is another for each joint has the joint's colour.
    """
    angles = np.rad2deg(np.concatenate([table, table[:1]]) if closed else table)
    phase = np.arange(len(angles)) / (len(angles) - 1)
    for j, colour in enumerate(joint_colours(table.shape[1])):
        ax.plot(phase, angles[:, j], color=colour, linewidth=1.6)
    if isinstance(limit_deg, tuple):
        _ranges(ax, limit_deg, angles)
    else:
        _limits(ax, limit_deg, f"limit {limit_deg:g}°" if limit_deg else "", float(np.abs(angles).max()))
    ax.set_xlim(0, 1)
    return dress(ax, title, X_LABEL if closed else ONCE, "joint angle [deg]")


def speeds_rpm(table: Floats, cycle_duration_s: float, closed: bool = True) -> Floats:
    """Mean joint speed of every step, shape (T, m) [rpm]; of a transient (T - 1, m)."""
    steps = np.diff(np.concatenate([table, table[:1]]) if closed else table, axis=0)
    return steps * len(steps) / cycle_duration_s * 60 / (2 * np.pi)


def joint_speeds(
    speeds: Floats, ax: Axes, limit_rpm: float | None = None, title: str = "Joint speeds", closed: bool = True
) -> Axes:
    """A line per joint, (T, m) [rpm], at the middle of its steps; limits dashed."""
    steps, count = speeds.shape
    for j, colour in enumerate(joint_colours(count)):
        ax.plot((np.arange(steps) + 0.5) / steps, speeds[:, j], color=colour, linewidth=1.6)
    _limits(ax, limit_rpm, f"limit {limit_rpm:g} rpm" if limit_rpm else "", float(np.abs(speeds).max()))
    ax.set_xlim(0, 1)
    return dress(ax, title, X_LABEL if closed else ONCE, "joint speed [rpm]")


def joint_map(table: Floats, ax: Axes, title: str = "Joint table", reach: float | None = None) -> Axes:
    """The table as a picture: phase to the right, joints from tail (below) to head (above), colour for the angle.

    reach: of a scale that several pictures share, whose colour bar stands elsewhere [deg].
    """
    steps, count = table.shape
    degrees, shared = np.rad2deg(table), reach is not None
    reach = reach or float(np.abs(degrees).max()) or 1.0
    edges = np.arange(steps + 1) / steps, np.arange(count + 1) + 0.5
    mesh: QuadMesh = ax.pcolormesh(*edges, degrees.T, cmap=ANGLE_MAP, vmin=-reach, vmax=reach)
    mesh.set_rasterized(True)
    ax.yaxis.set_major_locator(MaxNLocator(integer=True, nbins=min(count, 10), min_n_ticks=1))
    if not shared:
        angle_bar(ax, reach)
    return dress(ax, title, X_LABEL, "joint (1 = next to the tail)", grid=False)


def angle_bar(ax: Axes | list[Axes], reach: float) -> None:
    """Colour bar of angles up to `reach` [deg]."""
    colour_bar(ax, ANGLE_MAP, -reach, reach, "joint angle [deg]", pad=0.02, aspect=30)


def joint_bar(ax: Axes | list[Axes], count: int) -> None:
    """Colour bar that names the joints' colours, one beside the other; of many shades, so that SVG has one image."""
    colours = ListedColormap(np.repeat(joint_colours(count), 1 + SHADES // count, axis=0))
    bar = colour_bar(ax, colours, 0.5, count + 0.5, "joint (1 = next to the tail)", pad=0.02, aspect=40)
    bar.locator = MaxNLocator(integer=True, nbins=min(count, 10), min_n_ticks=1)
    bar.update_ticks()


def _far(times: float) -> str:
    """How far above what is reached a limit is; of a body that hardly moves the number says nothing."""
    return f"{times:.2g} times" if times < 99.5 else "far above"


def _ranges(ax: Axes, limit_deg: Limit, angles: Floats) -> None:
    """Dashed lines at the ends of ranges that are not the same to either side, around which the picture is cut."""
    count = angles.shape[1]
    ranges, each = ranges_deg(limit_deg, count), of_each(limit_deg) is not None
    ax.axhline(0, color=GREY, linewidth=0.8)
    for joint, ends in enumerate(ranges if each else ranges[:1]):
        for end in ends:
            ax.axhline(end, color=joint_colours(count)[joint] if each else RED, linewidth=1.3, linestyle="--")
    low, high = min(ranges.min(), angles.min()), max(ranges.max(), angles.max())
    name = "limit of each joint in its colour" if each else f"limit {limit_words(limit_deg)}°"
    ax.annotate(
        name, (0.99, ranges.max()), xycoords=ax.get_yaxis_transform(), xytext=(0, 2), textcoords="offset points",
        ha="right", va="bottom", color=RED, fontsize=SMALL, bbox={"facecolor": "white", "linewidth": 0, "pad": 0.5},
    )  # fmt: skip
    ax.set_ylim(low - 0.06 * (high - low), high + 0.12 * (high - low))


def _limits(ax: Axes, limit: float | None, name: str, reach: float) -> None:
    """Dashed lines at +-limit, named; of one far above the data its name and how far, so that it leaves curves room."""
    ax.axhline(0, color=GREY, linewidth=0.8)
    top = 1.08 * reach or 1.0
    if limit and limit > FAR * reach > 0:
        top = 1.3 * reach
        ax.annotate(
            f"{name}, {_far(limit / reach)} what is reached", (0.99, 0.97), xycoords="axes fraction", ha="right",
            va="top", color=RED, fontsize=SMALL, bbox={"facecolor": "white", "linewidth": 0, "pad": 0.5},
        )  # fmt: skip
    elif limit:
        ax.axhline(limit, color=RED, linewidth=1.3, linestyle="--")
        ax.axhline(-limit, color=RED, linewidth=1.3, linestyle="--")
        top = max(top, 1.22 * limit)
        ax.annotate(
            name, (0.99, limit), xycoords=ax.get_yaxis_transform(), xytext=(0, 2), textcoords="offset points",
            ha="right", va="bottom", color=RED, fontsize=SMALL, bbox={"facecolor": "white", "linewidth": 0, "pad": 0.5},
        )  # fmt: skip
    ax.set_ylim(-top, top)
