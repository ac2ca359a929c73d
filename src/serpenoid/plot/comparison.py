"""Pictures of Exp, Sim and Resim: paths, errors along phase and along the body, heat maps, cost of transport."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from serpenoid.body import Floats
from serpenoid.compare.ratios import RatioStatistics
from serpenoid.compare.three import Comparison, Path
from serpenoid.plot.body import draw_body
from serpenoid.plot.style import BLUE, FAINT, GREEN, GREY, INK, ORANGE, RED, SMALL, dress, figure, legend_above

CLASSES = (("Exp", GREEN), ("Sim", ORANGE), ("Resim", BLUE))
# wide below, narrow above: where two agree, both are seen
LINES: dict[str, dict[str, Any]] = {"Exp": {"lw": 3.4}, "Sim": {"lw": 1.6}, "Resim": {"lw": 1.4, "ls": (0, (3, 2))}}
BODIES = {"Exp": 5.0, "Sim": 2.6, "Resim": 1.2}
MARGIN = 0.1  # of a figure [inches]
LETTERED = 14  # gaits or vertices: more numbers beside each other cannot be read


def comparison_figure(comparison: Comparison) -> Figure:
    """One passage: three paths, displacement against time, residual along phase and along the body."""
    fig = figure(9.4, 6.2)
    grid = fig.add_gridspec(2, 2)
    paths(comparison, fig.add_subplot(grid[0, 0]))
    displacements(comparison, fig.add_subplot(grid[0, 1]))
    residual_in_time(comparison, fig.add_subplot(grid[1, 0]))
    residual_along_body(comparison, fig.add_subplot(grid[1, 1]))
    cycle = f", cycle {comparison.cycle + 1}" if comparison.sim is not None else ""  # nothing commanded: no cycles
    fig.suptitle(f"{comparison.trial}{cycle}", fontsize=11, x=0.01, ha="left")
    return fig


def _three(comparison: Comparison) -> list[tuple[str, str, Path]]:
    found = {"Exp": comparison.exp, "Sim": comparison.sim, "Resim": comparison.resim}
    return [(name, colour, path) for name, colour in CLASSES if (path := found[name]) is not None]


def paths(comparison: Comparison, ax: Axes) -> Axes:
    """Centroid paths and the last bodies; the measured first body in grey."""
    for name, colour, path in _three(comparison):
        ax.plot(*path.poses[:, :2].T, color=colour, label=name, **LINES[name])
        body = path.vertices[-1]
        joints = range(1, len(body) - 1) if name == "Exp" else ()
        draw_body(body, ax, colour, width=BODIES[name], joints=joints)
    _, start, _ = draw_body(comparison.exp.vertices[0], ax, GREY, width=2.0)
    start.set_label("start")
    ax.set_aspect("equal", adjustable="datalim")
    dress(ax, "", "x [body lengths]", "y [body lengths]")
    legend_above(ax, 4)
    return ax


def displacements(comparison: Comparison, ax: Axes) -> Axes:
    """Distance from the start against time."""
    time = comparison.time_s - comparison.time_s[0]
    for name, colour, path in _three(comparison):
        gone = np.hypot(*(path.poses[:, :2] - path.poses[0, :2]).T)
        ax.plot(time, gone, color=colour, label=f"{name} {gone[-1]:.3f}", **LINES[name])
    if np.isfinite(comparison.resim_sd):
        end = comparison.resim.displacement
        ax.errorbar(time[-1], end, yerr=2 * comparison.resim_sd, color=BLUE, capsize=3, lw=1.2)
    dress(ax, "", "time [s]", "distance from the start [body lengths]")
    legend_above(ax, 3)
    return ax


def residual_in_time(comparison: Comparison, ax: Axes) -> Axes:
    """Body-velocity residual Exp - Resim, forward and left, averaged over twentieths of a second or more."""
    time = (comparison.time_s[1:] + comparison.time_s[:-1]) / 2 - comparison.time_s[0]
    residual = comparison.velocity_residual()
    size = max(1, len(time) // 120)
    keep = len(time) // size * size
    time, residual = (v[:keep].reshape(-1, size, *v.shape[1:]).mean(axis=1) for v in (time, residual))
    for column, name, colour in ((0, "forward", INK), (1, "left", RED)):
        ax.plot(time, residual[:, column], color=colour, lw=1.2, label=name)
    ax.axhline(0, color=GREY, lw=0.8)
    dress(ax, "", "time [s]", "Exp − Resim velocity\n[body lengths / s]")
    legend_above(ax, 2)
    return ax


def residual_along_body(comparison: Comparison, ax: Axes) -> Axes:
    """RMS speed residual of every vertex."""
    values = comparison.residual_along_body()
    ax.bar(np.arange(len(values)), values, color=BLUE, width=0.7)
    ax.set_xticks(np.arange(len(values))[:: 1 + len(values) // LETTERED])
    return dress(ax, "Exp − Resim", "vertex (0 = tail)", "RMS velocity residual\n[body lengths / s]")


def heat_maps(statistics: list[RatioStatistics], gaits: list[str]) -> Figure:
    """Xi of every pair of classes on one logarithmic scale, with what is published and what it hides below."""
    fig = figure(4.1 * len(statistics) + 0.9, 5.5)
    axes = fig.subplots(1, len(statistics), squeeze=False)[0]
    reach = max(1.25, max(float(np.exp(np.abs(np.log(s.quotients)).max())) for s in statistics))
    image = None
    for ax, s in zip(axes, statistics, strict=True):
        image = ax.imshow(s.quotients, cmap="PuOr_r", norm=LogNorm(1 / reach, reach))
        ticks = np.arange(len(gaits))
        shown = ticks if len(gaits) <= LETTERED else ticks[:: len(gaits) // 8]
        ax.set_xticks(shown, [gaits[i] for i in shown], rotation=90, fontsize=SMALL)
        ax.set_yticks(shown, [gaits[i] for i in shown], fontsize=SMALL)
        if len(gaits) <= 8:
            for (i, j), value in np.ndenumerate(s.quotients):
                dark = abs(np.log(value)) > 0.6 * np.log(reach)
                ax.text(
                    j, i, f"{value:.2f}", ha="center", va="center", fontsize=SMALL - 1, color="white" if dark else INK
                )
        dress(ax, s.pair, ratio_caption(s), "", grid=False)
        ax.xaxis.label.set_fontsize(SMALL)
    if image is not None:
        bar = fig.colorbar(image, ax=list(axes), shrink=0.6, pad=0.01)
        marks = [t for t in (0.25, 0.5, 0.8, 1.0, 1.25, 2.0, 4.0) if 1 / reach <= t <= reach]
        bar.set_ticks(marks, labels=[f"{t:g}" for t in marks])
        bar.minorticks_off()
        bar.outline.set_visible(False)
        bar.set_label("quotient Ξ of the performance ratios, row over column", fontsize=SMALL)
    fig.draw_without_rendering()  # squares as wide as their columns leave room above and below
    fig.set_figheight(min(fig.get_figheight(), fig.get_tightbbox().height + 2 * MARGIN))
    return fig


def ratio_caption(s: RatioStatistics) -> str:
    """The paper's two numbers, then bias, s (the SD of ln q), rank correlation, wrong pairs."""
    low, high = s.bias_interval
    s_low, s_high = s.s_interval
    return (
        f"mean {s.mean:.4f}, SD {s.std:.4f}\n"
        f"typical ratio {s.bias:.3f} [{low:.3f}, {high:.3f}]\n"
        f"SD of its logarithm {s.s:.4f} [{s_low:.4f}, {s_high:.4f}]\n"
        f"rank correlation {s.rank_text}, {len(s.wrong_pairs)} of {s.pair_count} pairs wrong"
    )


def scatter(classes: dict[str, Floats], ax: Axes) -> Axes:
    """Predicted against measured displacement of every gait, with the diagonal."""
    top = 1.08 * max(float(np.max(values)) for values in classes.values())
    ax.plot([0, top], [0, top], color=GREY, lw=1, ls=(0, (3, 2)))
    for name, colour, marker in (("Sim", ORANGE, "s"), ("Resim", BLUE, "o")):
        if name in classes:
            ax.plot(classes["Exp"], classes[name], marker, color=colour, ms=5, label=name, alpha=0.85)
    ax.set_xlim(0, top)
    ax.set_ylim(0, top)
    ax.set_aspect("equal")
    dress(ax, "", "measured displacement [body lengths]", "predicted [body lengths]")
    legend_above(ax, 2)
    return ax


def cost_curves(families: dict[str, Floats], ax: Axes) -> Axes:
    """Cost of transport against c, mean and SD over trials, the minimum of each family marked."""
    for (name, rows), colour in zip(families.items(), (BLUE, ORANGE, GREEN, RED, INK) * 4, strict=False):
        c, mean, std = rows.T
        ax.errorbar(c, mean, yerr=np.nan_to_num(std), color=colour, marker="o", ms=4, lw=1.4, capsize=3, label=name)
        best = int(mean.argmin())
        ax.plot(c[best], mean[best], marker="*", ms=14, color=colour, mec="white", mew=0.8, zorder=5)
    dress(ax, "", "dissipation coefficient c", "cost of transport P / (m g v), electrical")
    legend_above(ax, 4)
    return ax


def power_line(rate: Floats, power: Floats, idle: float, coefficient: float, ax: Axes) -> Axes:
    """Power against the model's dissipation rate, with the fitted line."""
    grid = np.array([0.0, 1.05 * float(rate.max())])
    ax.plot(grid, idle + coefficient * grid, color=BLUE, lw=1.4, label=f"{idle:.3g} W + {coefficient:.3g} x rate")
    ax.plot(rate, power, "o", color=INK, ms=4, label="cycles")
    ax.axhline(idle, color=FAINT, lw=1)
    dress(ax, "", "dissipation rate of the model [1 / s^2]", "electrical power [W]")
    legend_above(ax, 2)
    return ax
