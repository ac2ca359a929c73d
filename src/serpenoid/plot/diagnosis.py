"""Pictures of a diagnosis: paths before and after, the ladder, where and when residuals are, the ranking."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from serpenoid.body import Floats
from serpenoid.diagnose.data.used import length_unit
from serpenoid.diagnose.inference.prices import gained_by_chance
from serpenoid.diagnose.residuals.maps import on_floor, windows
from serpenoid.group import accumulate, relative
from serpenoid.parallel import in_processes
from serpenoid.plot import diagnosis_ladder, diagnosis_maps
from serpenoid.plot.both import save
from serpenoid.plot.joints import joint_angles, joint_bar
from serpenoid.plot.style import BLUE, INK, NORMAL, ORANGE, SMALL, dress, figure, fill_equal, legend_above

if TYPE_CHECKING:
    from serpenoid.diagnose.diagnose import Diagnosis
    from serpenoid.diagnose.inference.select import Selection

COLUMNS = 4
WIDE = 30.0  # times what chance gains: beyond, the line of chance would touch the axis
PARTS = {"actuation": "joints", "observation": "markers"}
Jobs = dict[str, Callable[[], Figure]]
LABELS = {"measured": INK, "baseline": ORANGE, "extended": BLUE}


def draw_motion(folder: Path, found: Selection) -> list[str]:
    """What the search for effects alone shows, so that it can be drawn before all is judged; names of the figures."""
    w = windows(found.motion, found.null.predictions, found.best.predictions)
    extended = bool(found.best.effects)
    # what takes longest is begun first
    jobs: Jobs = {"residuals": lambda: diagnosis_maps.residuals_figure(w, extended)}
    if extended:
        jobs["residuals-left"] = lambda: diagnosis_maps.left_figure(w)
    jobs["along-body"] = lambda: diagnosis_maps.body_figure(w, extended, found.scores)
    if on_floor(w, w.before):  # some square was visited often enough
        jobs["on-floor"] = lambda: diagnosis_maps.floor_figure(w, extended)
    return _draw(folder, jobs | {"ranking": lambda: ranking_figure(found)})


def draw_rest(folder: Path, d: Diagnosis) -> list[str]:
    """All other figures of a diagnosis."""
    jobs: Jobs = {"paths": lambda: paths_figure(d), "ladder": lambda: diagnosis_ladder.ladder_figure(d.ladder)}
    jobs |= {PARTS[s.error.name]: partial(diagnosis_ladder.parts_figure, s) for s in d.ladder if s.error.name in PARTS}
    return _draw(folder, jobs)


def draw_experiment(folder: Path, table: Floats) -> list[str]:
    """The joint table (T, m) of the next experiment."""
    return _draw(folder, {"next-experiment": lambda: table_figure(table)})


def _draw(folder: Path, jobs: Jobs) -> list[str]:
    in_processes([(_draw_one, (job, folder, name)) for name, job in jobs.items()])
    return list(jobs)


def _draw_one(job: Callable[[], Figure], folder: Path, name: str) -> None:
    save(job(), folder, name)


def paths_figure(d: Diagnosis) -> Figure:
    """Small multiples: every gait and cycle duration, paths from the measured first pose, heading along x."""
    tracks = d.motion.selection.motion.tracks
    settings = sorted({t.recording.setting for t in tracks})
    rows = -(-len(settings) // COLUMNS)
    fig = figure(9.6, 0.5 + 1.9 * rows)
    axes = fig.subplots(rows, min(COLUMNS, len(settings)), squeeze=False)
    for ax, setting in zip(axes.flat, settings, strict=False):
        paths(d, setting, ax)
    for ax in axes.flat[len(settings) :]:
        ax.set_axis_off()
    shown = [n for n in LABELS if n != "extended" or d.extension.effects]
    handles = [axes.flat[0].plot([], [], color=LABELS[n], lw=1.6, label=n)[0] for n in shown]
    fig.legend(handles=handles, loc="outside upper left", ncols=3, frameon=False, fontsize=NORMAL)
    return fig


def paths(d: Diagnosis, setting: tuple[str, float], ax: Axes) -> Axes:
    """Centroid of all repeats of one setting: measured, and predicted by fits to the other gaits."""
    drawn = (("baseline", d.held_out[0]), ("extended", d.held_out[1]))
    scale, unit = diagnosis_ladder.UNITS[length_unit(d.motion.selection.motion.tracks)]
    for i, track in enumerate(d.motion.selection.motion.tracks):
        if track.recording.setting != setting:
            continue
        for name, predictions in drawn:
            if name == "baseline" or d.extension.effects:
                _path(ax, accumulate(np.nan_to_num(predictions[i].displacement), np.zeros(3)), scale, LABELS[name], 1.8)
        _path(ax, relative(track.poses[0], track.poses), scale, INK, 0.8)
    dress(ax, "", f"x [{unit}]", f"y [{unit}]")
    ax.set_title(
        f"{setting[0]}, {setting[1]:.3g} s" if setting[1] else setting[0], fontsize=SMALL, loc="left", color=INK
    )
    fill_equal(ax)
    ax.xaxis.set_major_locator(MaxNLocator(nbins=4))
    return ax


def _path(ax: Axes, path: Floats, scale: float, colour: str, width: float) -> None:
    points = scale * path[:, :2]
    ax.plot(*points.T, color=colour, lw=width)
    ax.plot(*points[-1], "o", color=colour, ms=3)


def table_figure(table: Floats) -> Figure:
    """Joint angles of a table (T, m) over the cycle."""
    fig = figure(7.4, 2.9)
    ax = fig.add_subplot()
    joint_angles(table, ax, title="")
    joint_bar(ax, table.shape[1])
    return fig


MOST_RANKED = 12  # and what was chosen


def ranking_figure(found: Selection) -> Figure:
    """The best candidates by first-order gain."""
    scores = found.scores
    chosen, needed = {e.key for e in found.best.effects}, gained_by_chance(len(scores))
    gaining = [s for s in scores if s[2] > 0]
    best = [s for i, s in enumerate(gaining) if i < MOST_RANKED or (s[0], s[1]) in chosen]
    fig = figure(7.4, 1.3 + 0.24 * max(len(best), 3))
    ax = fig.add_subplot()
    colours = [BLUE if (n, p) in chosen else "#9CC3DB" for n, p, _ in best]
    ax.barh([n if p is None else f"{n} at {p}" for n, p, _ in best], [s for *_, s in best], color=colours)
    ax.invert_yaxis()
    dress(ax, "", "chi squared gained to first order, less its parameters' price", "")
    gains = [needed, *(s for *_, s in best)]
    if max(gains) > WIDE * needed:
        ax.set_xscale("log")
        ax.set_xlim(0.5 * min(gains), 2 * max(gains))
    else:
        ax.ticklabel_format(axis="x", style="plain")
        ax.set_xlim(0, 1.05 * max(gains))
    ax.axvline(
        needed, color=INK, lw=1.0, ls="--", label=f"{needed:.0f}: what the best of {len(scores)} gains by chance"
    )
    if BLUE in colours:
        ax.plot([], [], "s", color=BLUE, label="chosen")
    ax.plot([], [], "s", color="#9CC3DB", label="not chosen: less in full, or another explains it")
    legend_above(ax, 1)
    ax.grid(visible=False, axis="y")
    return fig
