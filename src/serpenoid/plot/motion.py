"""Bodies along the path: shapes at a few phases in the world, over the trace of the weighted centroid.

Legend: R rows, N vertices; lengths in body lengths.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.transforms import ScaledTranslation, Transform

from serpenoid import group
from serpenoid.body import Floats
from serpenoid.plot.body import draw_body, shapes
from serpenoid.plot.style import INK, PHASE_MAP, SMALL, around, dress
from serpenoid.trajectory import Trajectory

BAR_BELOW = 0.6  # inches from the axes down to a bar below their numbers and name
NICE = np.array([0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0])


def over_cycles(trajectory: Trajectory, cycles: int) -> tuple[Floats, Floats]:
    """Poses (R, 3) and vertices (R, N, 2) of `cycles` cycles: what the trajectory lacks repeats its first."""
    steps = trajectory.steps_per_cycle
    if len(trajectory.poses) == cycles * steps + 1:
        return trajectory.poses, trajectory.vertices
    poses, chains = trajectory.poses[: steps + 1], trajectory.vertices[: steps + 1]
    relative = group.relative(poses[:-1], poses[1:])
    long = group.accumulate(np.tile(relative, (cycles, 1)), poses[0])
    frames = shapes(poses, chains)
    return long, group.place(long, np.concatenate([np.tile(frames[:-1], (cycles, 1, 1)), frames[-1:]]))


def motion(
    trajectory: Trajectory,
    ax: Axes,
    cycles: int = 1,
    bodies: int = 8,
    title: str = "Shapes along the path",
    body_length_m: float | None = None,
    joints: Sequence[int] = (),
    bar_within: bool = True,
) -> Axes:
    """Bodies at `bodies` even moments from start to end, the centroid's trace, start and end, a scale bar.

    bar_within: the bar stands within the axes, below the bodies; else below the axes, where no wall can be.
    """
    poses, chains = over_cycles(trajectory, cycles)
    steps = trajectory.steps_per_cycle
    rows = np.unique(np.linspace(0, len(poses) - 1, bodies).round().astype(int))
    for row in rows:
        phase = row / steps if cycles == 1 else row % steps / steps
        draw_body(chains[row], ax, PHASE_MAP(phase), joints=joints)
    ax.plot(*poses[:, :2].T, color=INK, linewidth=1.6, zorder=3, label="weighted centroid")
    ax.plot(*poses[:1, :2].T, "o", markersize=7, color="white", markeredgecolor=INK, zorder=5, label="start")
    ax.plot(*poses[-1:, :2].T, "s", markersize=7, color=INK, zorder=5, label="end")
    ax.plot([], [], "o", markersize=8, color=PHASE_MAP(0.0), label="head")
    points = np.concatenate([chains[rows].reshape(-1, 2), poses[:, :2]])
    _scale_bar(points, ax, body_length_m, bar_within)
    around(points, ax, below=0.05 if bar_within else 0.0)
    return dress(ax, title, "x [body lengths]", "y [body lengths]")


def _scale_bar(points: Floats, ax: Axes, body_length_m: float | None, within: bool) -> None:
    """A bar of a round length and what it is, from the left end of the points on."""
    low, extent = points.min(0), float(np.ptp(points, axis=0).max())
    bar = float(NICE[np.searchsorted(NICE, 0.45 * np.ptp(points[:, 0]), side="right") - 1])
    x, y = float(low[0]), float(low[1] - 0.06 * extent)
    place: Transform = ax.transData
    if not within:
        down = ScaledTranslation(0, -BAR_BELOW, ax.get_figure(root=True).dpi_scale_trans)  # type: ignore[union-attr]
        y, place = 0.0, ax.get_xaxis_transform() + down
    ax.plot([x, x + bar], [y, y], color=INK, linewidth=3, solid_capstyle="butt", transform=place, clip_on=within)
    metres = f" = {bar * body_length_m:.2g} m" if body_length_m else ""
    words = f"{bar:g} body length{'' if bar == 1 else 's'}{metres}"
    ax.text(x + bar + 0.015 * extent, y, words, fontsize=SMALL, va="center", color=INK, transform=place)
