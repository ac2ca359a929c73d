"""Where and when residual motion is: along the phase, against speed, along the body, on the floor."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.quiver import Quiver

from serpenoid.body import Floats
from serpenoid.diagnose.inference.fits.prices import gained_by_chance
from serpenoid.diagnose.residuals.maps import Bin, Cell, Windows, by_phase, by_speed, cell_side, on_floor
from serpenoid.effects.catalogue import motion_effects
from serpenoid.plot.room import settle
from serpenoid.plot.style import (
    BLUE,
    FAINT,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    SMALL,
    colour_bar,
    dress,
    figure,
    fill_equal,
)

HEAT = colormaps["YlOrRd"]
MOST_TICKS = 14  # of vertices, that stand beside each other without touching
LARGE_GAINS = ((1e6, ", millions"), (1e3, ", thousands"), (0.0, ""))
TURN = 180 / np.pi
ARROW = 1.4  # squares that the arrow of the key is long: the next to it mostly point the same way
HEAD: dict[str, Any] = {"width": 0.003, "headwidth": 4.0, "headlength": 4.5, "headaxislength": 4.0, "minlength": 0.5}
PALE = 4.0  # times chance: the darkest colour at least
SPEEDS = {"m": ("mm/s", 1e3), "bl": ("body lengths/s", 1.0)}
AGAINST: tuple[tuple[str, str, Callable[[Windows], list[Bin]]], ...] = (
    ("phase", "phase [cycles]{pause}", by_phase),
    ("speed", "RMS speed of the vertices [{speed}]", by_speed),
)
LINES = ((GREEN, "s"), (PURPLE, "^"), (BLUE, "o"), (ORANGE, "D"))  # of effects that have a vertex
Scores = Sequence[tuple[str, int | None, float]]


def residuals_figure(w: Windows, extended: bool) -> Figure:
    """Three directions against phase and speed."""
    kinds = [(w.before, ORANGE, "baseline")] + ([(w.after, BLUE, "extended")] if extended else [])
    return _grid(w, kinds)


def left_figure(w: Windows) -> Figure:
    """The same of the extended model alone, on a scale of its own."""
    return _grid(w, [(w.after, BLUE, "extended")])


def directions(w: Windows) -> tuple[tuple[str, str, float], ...]:
    """What a window's velocity is made of: name, unit, and how many of it stand for one of the record's."""
    return ("forward", *SPEEDS[w.length_unit]), ("to the left", *SPEEDS[w.length_unit]), ("turning left", "°/s", TURN)


def _grid(w: Windows, kinds: list[tuple[Floats, str, str]]) -> Figure:
    fig = figure(8.6, 6.0)
    axes = fig.subplots(3, len(AGAINST), sharex="col", sharey="row")
    pause = ", 1 = pause" if (w.phase >= 1).any() else ""  # no animal has one
    speed, per = SPEEDS[w.length_unit]
    for column, (field, label, bins) in enumerate(AGAINST):
        words = label.format(speed=speed, pause=pause)
        scale = per if field == "speed" else 1.0
        for row in range(3):
            against(w, kinds, row, scale * getattr(w, field), _scaled(bins(w), scale), axes[row, column])
            axes[row, column].set_xlabel(words if row == 2 else "", fontsize=SMALL, color=INK)
    for row, (name, unit, _) in enumerate(directions(w)):
        axes[row, 0].set_ylabel(f"{name} [{unit}]", fontsize=SMALL, color=INK)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    fig.legend(handles, labels, loc="upper left", ncols=4, frameon=False, fontsize=SMALL)
    settle(fig, axes, above=0.32, title=0.03)
    return fig


def _scaled(bins: list[Bin], scale: float) -> list[Bin]:
    """With ends in another unit."""
    return [replace(b, low=scale * b.low, high=scale * b.high) for b in bins]


def against(
    w: Windows, kinds: list[tuple[Floats, str, str]], direction: int, x: Floats, bins: list[Bin], ax: Axes
) -> Axes:
    """Residual velocity of every window, and means of bins; the band is what 95 % of windows do by chance."""
    scale = directions(w)[direction][2]
    at, noise = [b.middle for b in bins], 2 * scale * np.array([b.noise[direction] for b in bins])
    widths = [b.high - b.low for b in bins]
    ax.bar(at, 2 * noise, widths, bottom=-noise, color=FAINT, lw=0, label="noise, 95 %", zorder=0)
    for residual, colour, label in kinds:
        mean = [b.before[direction] if label == "baseline" else b.after[direction] for b in bins]
        ax.plot(x, scale * residual[:, direction], ".", color=colour, ms=4, alpha=0.45, mew=0)
        mark = "o" if label == "baseline" else "s"
        ax.plot(at, scale * np.array(mean), "-", marker=mark, color=colour, ms=3.5, lw=1.2, label=f"{label}, mean")
    largest = max(np.abs(scale * r[:, direction]).max() for r, _, _ in kinds)
    reach = 1.1 * max(largest, noise.max())
    ax.set_ylim(-reach, reach)
    ax.axhline(0, color=GREY, lw=0.7)
    ax.set_xlim(bins[0].low, bins[-1].high)
    return dress(ax, "", "", "")


def body_figure(w: Windows, extended: bool, scores: Scores, pieces: int = 0) -> Figure:
    """Residual velocity of every vertex across and along the body; what an effect at each vertex would gain.

    pieces: of each edge, whose middles are vertices.
    """
    placed = any(place is not None for _, place, _ in scores)
    fig = figure(9.6 if placed else 6.6, 3.2)
    axes = fig.subplots(1, 3 if placed else 2)
    for ax, component, name in ((axes[0], 1, "across the body"), (axes[1], 0, "along the body")):
        vertex_speeds(w, extended, component, name, ax)
    style: dict[str, Any] = {"ncols": 3, "frameon": False, "fontsize": SMALL}
    fig.legend(*axes[0].get_legend_handles_labels(), loc="upper left", **style)
    if placed:
        vertex_scores(scores, axes[2])
        fig.legend(*axes[2].get_legend_handles_labels(), loc="upper right", **style)
    for ax in axes:
        ax.set_xticks(np.arange(0, w.points.shape[1], -(-w.points.shape[1] // MOST_TICKS)))
        amid = {0: "", 1: "; odd: middles of edges"}.get(pieces, f"; {pieces + 1} k: the body's vertex k")
        ax.set_xlabel(f"vertex (0 = tail{amid})")
    settle(fig, axes, above=0.3, title=0.27)
    return fig


def vertex_speeds(w: Windows, extended: bool, component: int, name: str, ax: Axes) -> Axes:
    """RMS over the windows of play."""
    unit, scale = SPEEDS[w.length_unit]
    noise = scale * w.noise_along_body()[:, component]
    vertices = np.arange(len(noise))
    ax.fill_between(vertices, 0, noise, color=FAINT, lw=0, label="noise level")
    ax.plot(vertices, scale * w.along_body(w.before)[:, component], "-o", color=ORANGE, ms=4, label="baseline")
    if extended:
        ax.plot(vertices, scale * w.along_body(w.after)[:, component], "-s", color=BLUE, ms=4, label="extended")
    ax.set_ylim(bottom=0)
    return dress(ax, f"Residual {name}", "", f"RMS [{unit}]")


def vertex_scores(scores: Scores, ax: Axes) -> Axes:
    """Gain to first order of each effect that has a vertex, along the body; what only harms is at zero."""
    names = [kind.name for kind in motion_effects() if kind.place == "vertex"]
    largest = max([gained_by_chance(len(scores)), *(s for n, _, s in scores if n in names)])
    unit, words = next((least or 1.0, words) for least, words in LARGE_GAINS if largest >= least)
    for name, (colour, mark) in zip(names, cycle(LINES), strict=False):
        mine = sorted((p, max(s, 0.0) / unit) for n, p, s in scores if n == name and p is not None)
        if mine:
            places, gains = zip(*mine, strict=True)
            every = np.arange(places[0], places[-1] + 1)
            at = np.full(len(every), np.nan)  # no line across vertices that were not tried
            at[np.subtract(places, places[0])] = gains
            ax.plot(every, at, "-", marker=mark, color=colour, ms=4, label=name)
    ax.set_ylim(0, 1.1 * largest / unit)
    return dress(ax, "Gain there, to first order", "", f"chi squared gained{words}")


def floor_figure(w: Windows, extended: bool) -> Figure:
    """Residual velocities of the vertices on squares of the floor, before and after, on one scale."""
    kinds = [(w.before, "Baseline")] + ([(w.after, "Extended")] if extended else [])
    maps = [on_floor(w, residual) for residual, _ in kinds]
    side = cell_side(w)
    unit, scale = metric(side) if w.length_unit == "m" else ("body lengths", 1.0)
    speed, per = SPEEDS[w.length_unit]
    fastest = max(float(np.hypot(*c.mean)) for cells in maps for c in cells)
    scales = FloorScales(
        side,
        unit,
        scale,
        speed,
        per,
        float(f"{per * fastest:.1g}"),
        max(PALE, *(c.rms / c.noise for cells in maps for c in cells)),
    )
    fig = figure(9.6 if extended else 5.4, 4.2)
    axes = fig.subplots(1, len(kinds), squeeze=False).flat
    every = [squares(cells, name, scales, ax) for ax, cells, (_, name) in zip(axes, maps, kinds, strict=True)]
    words = f"mean: {scales.key:g} {speed}"
    fig.axes[-1].quiverkey(every[-1], 0.7, 1.04, scales.key, words, labelpos="E", fontproperties={"size": SMALL})
    colour_bar(list(fig.axes), HEAT, 0, scales.darkest, "RMS over noise", shrink=0.8)
    return fig


@dataclass(frozen=True)
class FloorScales:
    """What panels share: side of a square [m], unit and its number per metre; unit of speeds and its number per m/s,
    key arrow in it; darkest colour."""

    side: float
    unit: str
    per_metre: float
    speed: str
    per_speed: float
    key: float
    darkest: float


def metric(side: float) -> tuple[str, float]:
    """Unit in which the floor is read, and how many of them a metre has."""
    return ("m", 1.0) if side >= 0.02 else ("mm", 1e3) if side >= 2e-5 else ("\N{MICRO SIGN}m", 1e6)


def squares(cells: Sequence[Cell], name: str, s: FloorScales, ax: Axes) -> Quiver:
    """Colour: RMS over what chance makes of it; arrow: mean."""
    place = s.per_metre * np.array([(c.x, c.y) for c in cells])
    mean = s.per_speed * np.array([c.mean for c in cells])
    over = np.array([c.rms / c.noise for c in cells])
    half = s.per_metre * s.side / 2
    corners = np.array([(-half, -half), (half, -half), (half, half), (-half, half)])
    ax.add_collection(
        PolyCollection(place[:, None] + corners, facecolors=HEAT(over / s.darkest), edgecolors="white", lw=0.5)
    )
    arrows = ax.quiver(
        *place.T, *mean.T, color=INK, angles="xy", scale_units="xy", scale=s.key / (ARROW * 2 * half), pivot="mid",
        **HEAD,
    )  # fmt: skip
    dress(ax, name, f"x [{s.unit}]", f"y [{s.unit}]", grid=False)
    fill_equal(ax)
    return arrows
