"""Residuals window by window, each trial on a line of its own, repeats of a setting below each other."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import AsinhNorm
from matplotlib.figure import Figure

from serpenoid.body import Floats
from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.data.noise import residuals
from serpenoid.diagnose.data.windows import Prediction, Track
from serpenoid.plot.room import settle
from serpenoid.plot.style import ANGLE_MAP, FAINT, GREY, INK, NORMAL, SMALL, dress, figure

DIRECTIONS = ("forward", "to the left", "turning left")
CHANCE = 2.0  # standard deviations: up to there the scale of colours is linear
LINE, NAME = 0.10, 0.17  # height of a trial's line, of a setting's name at least [inches]
LEAST = 1.5  # height of all lines together, for the name of the colours [inches]
Kind = tuple[str, Sequence[Prediction]]


def trials_figure(motion: Motion, kinds: Sequence[Kind]) -> Figure:
    """A row of panels for each of the kinds (name, predictions), a column for each direction, on one scale."""
    order = sorted(range(len(motion.tracks)), key=lambda i: motion.tracks[i].recording.setting)
    tracks = [motion.tracks[i] for i in order]
    over = [in_chance(motion, tracks, [predictions[i] for i in order]) for _, predictions in kinds]
    reach = max(2 * CHANCE, *(float(np.nanmax(np.abs(r), initial=0.0)) for left in over for r in left))
    scale = AsinhNorm(CHANCE, -reach, reach)
    lines = max(LINE * len(tracks), NAME * len({t.recording.setting for t in tracks}), LEAST / len(kinds))
    fig = figure(9.6, 0.9 + len(kinds) * (0.25 + lines))
    axes = fig.subplots(len(kinds), 3, sharex=True, sharey=True, squeeze=False)
    for row, ((name, _), left) in enumerate(zip(kinds, over, strict=True)):
        for column, direction in enumerate(DIRECTIONS):
            ax = axes[row, column]
            windows_in_time(tracks, [r[:, column] for r in left], scale, ax)
            last, first = row == len(kinds) - 1, row == 0
            dress(ax, direction if first else "", "time [s]" if last else "", name if not column else "", grid=False)
            ax.title.set_fontsize(NORMAL)
    settle(fig, axes, above=0.05, title=0.22, right=0.8)
    place = axes[-1, -1].get_position()
    cax = fig.add_axes((place.x1 + 0.01, place.y0, 0.015, axes[0, 0].get_position().y1 - place.y0))
    bar = fig.colorbar(ScalarMappable(scale, ANGLE_MAP), cax=cax)
    decades = [t for t in (2, 10, 50, 200, 1000, 5000) if t <= reach]
    bar.set_ticks([-t for t in reversed(decades)] + [0, *decades], labels=None)
    bar.ax.yaxis.set_major_formatter("{x:g}")
    bar.minorticks_off()
    bar.set_label("residual over chance [SD]", fontsize=SMALL, color=INK)
    bar.ax.tick_params(labelsize=SMALL, color=GREY, labelcolor=INK)
    bar.outline.set_visible(False)
    return fig


def in_chance(motion: Motion, tracks: Sequence[Track], predictions: Sequence[Prediction]) -> list[Floats]:
    """Measured minus predicted displacement of each window (B - 1, 3), in units of what chance makes of it."""
    return [r / motion.noise.of(t) for t, r in zip(tracks, residuals(tracks, predictions), strict=True)]


def windows_in_time(tracks: Sequence[Track], left: Sequence[Floats], scale: AsinhNorm, ax: Axes) -> Axes:
    """A box for each window (B - 1,) from its beginning to its end, coloured; grey where there is none."""
    corners: list[list[tuple[float, float]]] = []
    values: list[float] = []
    for line, (track, value) in enumerate(zip(tracks, left, strict=True)):
        ends = track.time[track.boundaries]
        for a, b, v in zip(ends[:-1], ends[1:], value, strict=True):
            if np.isfinite(v):
                corners.append([(a, line - 0.46), (b, line - 0.46), (b, line + 0.46), (a, line + 0.46)])
                values.append(v)
    boxes = PolyCollection(corners, facecolors=ANGLE_MAP(scale(values)), lw=0)
    boxes.set_rasterized(True)
    ax.add_collection(boxes)
    ax.set_facecolor(FAINT)
    ax.set_xlim(0, max(float(t.time[-1]) for t in tracks))
    ax.set_ylim(len(tracks) - 0.5, -0.5)
    _name_settings(tracks, ax)
    return ax


def _name_settings(tracks: Sequence[Track], ax: Axes) -> None:
    """A name beside the lines of each setting, a stroke between settings."""
    first, middles, names = 0, [], []
    for setting, repeats in groupby(t.recording.setting for t in tracks):
        count = len(list(repeats))
        middles.append(first + (count - 1) / 2)
        names.append(setting_name(setting))
        first += count
        if first < len(tracks):
            ax.axhline(first - 0.5, color=INK, lw=0.6)
    ax.set_yticks(middles, names)


def setting_name(setting: tuple[str, float]) -> str:
    """As `gait01, 4.26 s`."""
    return f"{setting[0]}, {setting[1]:.3g} s" if setting[1] else setting[0]
