"""Pictures of a diagnosis: paths before and after, the ladder, residuals along the phase, the ranking."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from serpenoid.diagnose.geometry import travel
from serpenoid.diagnose.noise import residuals
from serpenoid.plot.figures import save
from serpenoid.plot.style import BLUE, GREY, INK, ORANGE, dress, figure, legend_above

if TYPE_CHECKING:
    from serpenoid.diagnose.diagnose import Diagnosis

AXES = ("forward", "left", "turn")


def draw_all(folder: Path, d: Diagnosis) -> None:
    """Four figures into the folder."""
    fig = figure(7.4, 5.2)
    paths(d, fig.add_subplot())
    save(fig, folder, "paths")
    fig = figure(7.4, 2.4)
    ladder(d, fig.add_subplot())
    save(fig, folder, "ladder")
    fig = figure(7.4, 5.4)
    for i, ax in enumerate(fig.subplots(3, 1, sharex=True)):
        along_phase(d, i, ax)
    save(fig, folder, "residuals")
    fig = figure(7.4, 3.6)
    ranking(d, fig.add_subplot())
    save(fig, folder, "ranking")


def paths(d: Diagnosis, ax: Axes) -> Axes:
    """Measured and predicted paths of every trial, from the measured start pose [m]."""
    found = d.motion.selection
    for i, track in enumerate(found.motion.tracks):
        kinds = ((found.null.predictions[i], ORANGE, "baseline"), (found.best.predictions[i], BLUE, "extended"))
        for p, colour, label in kinds:
            path = travel(np.nan_to_num(p.displacement), track.poses[0])
            ax.plot(*path[:, :2].T, color=colour, lw=1.2, label=label if i == 0 else None)
        ax.plot(*track.poses[:, :2].T, color=INK, lw=0.7, label="measured" if i == 0 else None)
    dress(ax, "Paths of the centroid", "x [m]", "y [m]")
    ax.set_aspect("equal", adjustable="datalim")
    legend_above(ax, 3)
    return ax


def ladder(d: Diagnosis, ax: Axes) -> Axes:
    """What is left on every rung over its floor."""
    names, left = [r.name for r in d.rungs], [r.left for r in d.rungs]
    ax.barh(names, left, color=BLUE)
    ax.axvline(1.0, color=INK, lw=0.8)
    ax.invert_yaxis()
    return dress(ax, "What is left", "misfit over floor", "")


def along_phase(d: Diagnosis, component: int, ax: Axes) -> Axes:
    """Residuals of one component against phase, before and after [SD]."""
    found = d.motion.selection
    for predictions, colour, label in (
        (found.null.predictions, ORANGE, "baseline"),
        (found.best.predictions, BLUE, "extended"),
    ):
        x, y = [], []
        for track, left in zip(found.motion.tracks, residuals(found.motion.tracks, predictions), strict=True):
            x.append(track.phase + np.where(track.playing, 0.0, 0.06))
            y.append(left[:, component] / found.motion.noise.of(track)[:, component])
        ax.plot(np.concatenate(x), np.concatenate(y), ".", color=colour, ms=3, alpha=0.6, label=label)
    ax.axhspan(-2, 2, color=GREY, alpha=0.2, lw=0)
    ax.set_yscale("symlog", linthresh=3)
    return dress(ax, AXES[component], "phase [cycles]" if component == 2 else "", "[SD]")


def ranking(d: Diagnosis, ax: Axes) -> Axes:
    """The best candidates by first-order gain."""
    best = [s for s in d.motion.selection.scores if s[2] > 0][:10]
    labels = [n if p is None else f"{n} at {p}" for n, p, _ in best]
    ax.barh(labels, [s for *_, s in best], color=BLUE)
    ax.invert_yaxis()
    return dress(ax, "Gain on held-out gaits", "chi squared", "")
