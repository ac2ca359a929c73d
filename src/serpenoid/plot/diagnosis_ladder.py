"""Pictures of the residuals stage by stage, each with its noise level, and joint by joint, marker by marker."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from serpenoid.plot.room import settle
from serpenoid.plot.style import BLUE, GREY, INK, ORANGE, SMALL, dress, figure, legend_above

if TYPE_CHECKING:
    from serpenoid.diagnose.stages.ladder import Error, Step

UNITS = {"m": (1e3, "mm"), "bl": (1.0, "body lengths"), "rad": (180 / np.pi, "°")}
MOST_TICKS = 24  # numbers that stand beside each other without touching
TITLES = {
    "actuation": "commanded against\nrealised shape",
    "observation": "realised shape\nagainst markers",
    "motion": "realised shape against\nrealised motion",
    "whole": "commanded shape\nagainst realised motion",
}


def ladder_figure(ladder: Sequence[Step]) -> Figure:
    """One panel a stage, since units differ: error before and after, and how many times the noise level they are."""
    fig = figure(2.4 * max(len(ladder), 1.5), 2.9)
    axes = fig.subplots(1, len(ladder), squeeze=False)
    for ax, step in zip(axes.flat, ladder, strict=True):
        stage(step.error, ax)
    fig.legend(*fig.axes[0].get_legend_handles_labels(), loc="upper left", frameon=False, fontsize=SMALL)
    settle(fig, axes, above=0.3, title=0.42)
    return fig


def stage(error: Error, ax: Axes) -> Axes:
    """Two bars and the noise level."""
    scale, unit = UNITS[error.unit]
    for i, (value, colour) in enumerate(((error.before, ORANGE), (error.after, BLUE))):
        ax.bar(i, scale * value, color=colour, width=0.62)
        top = scale * max(value, error.noise_level)  # clear of the line
        ratio = value / error.noise_level
        times = f"{ratio:.{int(ratio < 10)}f} \N{MULTIPLICATION SIGN}\nnoise"
        ax.text(i, top, times, ha="center", va="bottom", fontsize=SMALL)
    ax.axhline(scale * error.noise_level, color=INK, lw=1.0, ls="--", label="noise level")
    ax.set_xticks([0, 1], ["before", "after"])
    ax.set_xlim(-0.6, 1.6)
    ax.set_ylim(0, 1.3 * scale * max(error.before, error.after, error.noise_level))
    dress(ax, "", "", f"RMS [{unit}]")
    ax.set_title(TITLES[error.name], fontsize=SMALL + 0.5, loc="left", color=INK)
    ax.grid(visible=False, axis="x")
    return ax


def parts_figure(step: Step) -> Figure:
    """Every joint or marker: error before and after on a logarithmic scale, with the noise level."""
    fig = figure(7.4, 2.7)
    settle(fig, parts(step, fig.add_subplot()), above=0.3)
    return fig


def parts(step: Step, ax: Axes) -> Axes:
    """Dots, since a logarithmic scale has no zero to stand on."""
    scale, unit = UNITS[step.error.unit]
    numbers = [int(p.name.split()[-1]) for p in step.parts]
    noise_level = [scale * p.noise_level for p in step.parts]
    for p, k in zip(step.parts, numbers, strict=True):
        ax.plot([k, k], [scale * p.before, scale * p.after], color=GREY, lw=0.8, zorder=1)
    ax.plot(numbers, [scale * p.before for p in step.parts], "o", color=ORANGE, ms=6, label="before")
    after, least = np.array([scale * p.after for p in step.parts]), 0.4 * min(noise_level)
    ax.plot(numbers, after, "o", color=BLUE, ms=4, label="after")
    if (below := after < least).any():  # an arrow on the axis
        ax.plot(np.array(numbers)[below], np.full(below.sum(), least), "v", color=BLUE, ms=7, clip_on=False, zorder=5)
    at = np.array(numbers)
    ax.hlines(noise_level, at - 0.45, at + 0.45, color=INK, lw=1.0, linestyles="--", label="noise level")
    ax.set_yscale("log")
    ax.set_ylim(least, 2 * max([scale * p.before for p in step.parts] + [4 * f for f in noise_level]))
    ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.yaxis.set_minor_formatter("")
    ax.set_xticks(numbers[:: -(-len(numbers) // MOST_TICKS)])
    ax.set_xlim(at.min() - 0.7, at.max() + 0.7)
    dress(ax, "", step.parts[0].name.split()[0], f"RMS [{unit}]")
    legend_above(ax, 3)
    return ax
