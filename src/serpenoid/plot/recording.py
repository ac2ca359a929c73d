"""Pictures of a recording: markers and bodies on the floor, what was seen when, commanded against measured angles.

Legend: F frames, N vertices, m joints.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from serpenoid.body import Floats
from serpenoid.measure.cells import clock as moment
from serpenoid.measure.film.quality import find_holes
from serpenoid.measure.trial import Motion, Trial
from serpenoid.plot.body import draw_body
from serpenoid.plot.style import BLUE, CHAIN_MAP, FAINT, GREY, INK, ORANGE, RED, SMALL, dress, figure, legend_above

LONG_AGO = 100.0  # times the recording's length: numbers of a clock that began earlier are too long for an axis
MOST_COLUMNS = 4000  # of a picture: more are narrower than its dots
DRAWN = 400  # points of a path: more cannot be seen


def trial_figure(trial: Trial) -> Figure:
    """Floor, visibility and joint angles of one trial; a path that is wider than high has the whole width."""
    fig = figure(9.2, 6.4)
    wide = trial.motion is not None and _is_wide(trial.motion.markers)
    grid = fig.add_gridspec(2, 2, width_ratios=[1.0, 1.0] if wide else [1.15, 1.0])
    floor(trial, fig.add_subplot(grid[0, :] if wide else grid[:, 0]))
    visibility(trial, fig.add_subplot(grid[1, 0] if wide else grid[0, 1]))
    angles(trial, fig.add_subplot(grid[1, 1]))
    fig.suptitle(f"{trial.name}: what was recorded", fontsize=11, x=0.01, ha="left")
    return fig


@dataclass(frozen=True)
class Clock:
    """The time axis of a recording: moments as they stand in its file, or, where these are long numbers, since its
    first frame. start, end: in the file [s]; zero: what the axis begins to count from [s]."""

    start: float
    end: float
    zero: float

    @classmethod
    def of(cls, motion: Motion) -> Clock:
        """Of a motion file."""
        start, end = float(motion.time_s[0]), float(motion.time_s[-1])
        return cls(start, end, start if abs(start) > LONG_AGO * (end - start) else 0.0)

    @property
    def ends(self) -> tuple[float, float]:
        """Of the axis."""
        return self.start - self.zero, self.end - self.zero

    @property
    def label(self) -> str:
        """Name of the axis."""
        return f"time since {moment(self.zero)} s [s]" if self.zero else "time [s]"

    def at(self, time_s: Any) -> Any:
        """Moments of the file on the axis."""
        return time_s - self.zero


def evenly(time_s: Floats, seen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """What frames (N, F) show, at even times: a picture knows no others. Nothing where frames are missing."""
    apart = np.diff(time_s)
    count = int(min(max(round(float(time_s[-1] - time_s[0]) / float(np.median(apart))) + 1, 2), MOST_COLUMNS))
    at = np.linspace(time_s[0], time_s[-1], count)
    after = np.clip(np.searchsorted(time_s, at), 1, len(time_s) - 1)
    nearest = np.where(at - time_s[after - 1] < time_s[after] - at, after - 1, after)
    missing = np.isin(after, find_holes(time_s)) & (np.abs(time_s[nearest] - at) > np.median(apart))
    return np.asarray(seen[:, nearest] & ~missing)


def _is_wide(markers: Floats) -> bool:
    """Of positions (F, N, 2), some of them NaN."""
    width, height = np.nanmax(markers, axis=(0, 1)) - np.nanmin(markers, axis=(0, 1))
    return bool(width > 1.2 * height)


def floor(trial: Trial, ax: Axes) -> Axes:
    """Paths of the markers, the centroid, and the body at the start and end of every passage."""
    motion = trial.motion
    if motion is None:
        return _nothing(ax)
    step = max(1, len(motion.time_s) // DRAWN)
    count = motion.markers.shape[1]
    for vertex in range(count):
        ax.plot(*motion.markers[::step, vertex].T, color=CHAIN_MAP(vertex / max(count - 1, 1)), lw=0.6, alpha=0.55)
    ax.plot(*motion.smooth_poses[::step, :2].T, color=INK, lw=1.6, label="centroid")
    for passage in trial.passages:
        for frame, colour in ((passage.first, GREY), (passage.last, BLUE)):
            draw_body(motion.vertices[frame], ax, colour, 2.4, trial.body.joint_vertices)
    for jump in motion.jumps:
        if jump.vertex is None:
            ax.plot(*motion.poses[jump.frame, :2], marker="x", color=RED, ms=8, mew=2)
    ax.set_aspect("equal", adjustable="datalim")
    if trial.passages:
        what = "a cycle" if trial.schedule else "the recording"
        for colour, label in ((GREY, f"body as {what} begins"), (BLUE, "body as it ends")):
            ax.plot([], [], color=colour, lw=2.4, label=label)
    if any(jump.vertex is None for jump in motion.jumps):
        ax.plot([], [], "x", color=RED, ms=8, mew=2, label="the body jumps")
    unit = "body lengths"
    dress(ax, "Markers (tail dark, head light)", f"x [{unit}]", f"y [{unit}]")
    legend_above(ax, 3)
    return ax


def visibility(trial: Trial, ax: Axes) -> Axes:
    """Which vertex was seen when; gaps and jumps marked."""
    motion = trial.motion
    if motion is None:
        return _nothing(ax)
    clock, seen = Clock.of(motion), np.isfinite(motion.markers[..., 0]).T
    shares = seen.mean(axis=1)
    extent = (*clock.ends, -0.5, seen.shape[0] - 0.5)
    ax.imshow(
        np.where(evenly(motion.time_s, seen), 0.12, 0.75), aspect="auto", origin="lower", extent=extent, cmap="Greys",
        vmin=0, vmax=1, interpolation="nearest",
    )  # fmt: skip
    ax.yaxis.set_major_locator(MaxNLocator(integer=True))
    for vertex in (0, len(shares) - 1):
        label = "tail" if vertex == 0 else "head"
        ax.text(
            1.01,
            vertex,
            f"{label} {shares[vertex]:.0%}",
            transform=ax.get_yaxis_transform(),
            fontsize=SMALL,
            va="center",
        )
    for gap in motion.gaps:
        if not gap.short:
            ax.axvspan(*clock.at(motion.time_s[[gap.first, gap.last]]), color=ORANGE, alpha=0.4, lw=0)
    for jump in motion.jumps:
        if jump.vertex is None:  # the whole body
            ax.axvline(clock.at(jump.time_s), color=RED, lw=1.0)
        else:
            ax.plot(clock.at(jump.time_s), jump.vertex, marker="x", color=RED, ms=6, mew=1.5)
    title = f"Dark: {motion.hidden_said}".replace("; ", ";\n")
    title += "\norange: too long to bridge" if any(not gap.short for gap in motion.gaps) else ""
    title += "\nred: jumps (cross: one marker, line: the body)" if motion.jumps else ""
    ax.set_xlim(*clock.ends)
    return dress(ax, title, clock.label, "vertex", grid=False)


def angles(trial: Trial, ax: Axes) -> Axes:
    """Three joints: commanded, by servo, by markers and servo together."""
    motion = trial.motion
    if motion is None:
        return _nothing(ax)
    joints = sorted({0, motion.joint_angles.shape[1] // 2, motion.joint_angles.shape[1] - 1})
    step = max(1, len(motion.time_s) // (4 * DRAWN))
    clock, time = Clock.of(motion), motion.time_s[::step]
    commanded = None
    if trial.schedule is not None and trial.start_source != "none":
        commanded = trial.schedule.commanded(time)
    for joint in joints:
        colour = CHAIN_MAP(joint / max(motion.joint_angles.shape[1] - 1, 1))
        ax.plot(clock.at(time), motion.smooth_angles[::step, joint], color=colour, lw=1.3, label=f"joint {joint + 1}")
        if commanded is not None:
            ax.plot(clock.at(time), commanded[:, joint], color=INK, lw=0.9, ls=(0, (3, 2)), zorder=3)
    for passage in trial.passages:
        ax.axvspan(*clock.at(motion.time_s[[passage.first, passage.last]]), color=FAINT, alpha=0.6, lw=0, zorder=0)
    ax.set_xlim(*clock.ends)
    dress(ax, "", clock.label, "joint angle [rad]")
    if commanded is not None:
        ax.plot([], [], color=INK, lw=0.9, ls=(0, (3, 2)), label="commanded")
    legend_above(ax, 4)
    return ax


def repeats(trials: tuple[Trial, ...], ax: Axes) -> Axes:
    """Repeated trials of one gait, each moved to start at the origin with heading along x (the paper's overlay)."""
    colours = [BLUE, ORANGE, "#009E73", "#CC79A7", RED]
    index = 0
    for trial in trials:
        if trial.motion is None:
            continue
        for passage in trial.passages:
            poses = trial.motion.smooth_poses[passage.frames]
            heading = np.nanmean(poses[:, 2])
            c, s = np.cos(heading), np.sin(heading)
            moved = (poses[:, :2] - poses[0, :2]) @ np.array([[c, -s], [s, c]])
            label = trial.name if passage is trial.passages[0] else None
            ax.plot(*moved.T, color=colours[index % len(colours)], lw=1.2, alpha=0.8, label=label)
        index += 1
    ax.set_aspect("equal", adjustable="datalim")
    dress(ax, "", "along the mean heading [body lengths]", "across [body lengths]")
    legend_above(ax, 3)
    return ax


def _nothing(ax: Axes) -> Axes:
    ax.text(0.5, 0.5, "no motion file", ha="center", va="center", color=GREY, transform=ax.transAxes)
    ax.set_axis_off()
    return ax
