"""Residuals window by window, each trial on a line of its own, repeats of a setting below each other."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate, groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import AsinhNorm
from matplotlib.figure import Figure

from serpenoid.body import Floats
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.noise import residuals
from serpenoid.diagnose.data.windows.windows import Prediction, Track
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
    named = [(first + (count - 1) / 2, name) for first, count, name in _settings(tracks)]
    axes[0, 0].set_yticks(*zip(*named, strict=True))  # of all panels: they share it
    settle(fig, axes, above=0.05, title=0.22, right=0.8)
    place = axes[-1, -1].get_position()
    cax = fig.add_axes((place.x1 + 0.01, place.y0, 0.015, axes[0, 0].get_position().y1 - place.y0))
    bar = fig.colorbar(ScalarMappable(scale, ANGLE_MAP), cax=cax)
    decades = [t for t in (2, 10, 50, 200, 1000, 5000) if t <= reach]
    bar.set_ticks([-t for t in reversed(decades)] + [0, *decades], labels=None)
    bar.ax.yaxis.set_major_formatter("{x:g}")
    bar.minorticks_off()
    bar.set_label("residual over noise [SD]", fontsize=SMALL, color=INK)
    bar.ax.tick_params(labelsize=SMALL, color=GREY, labelcolor=INK)
    bar.outline.set_visible(False)
    return fig


def in_chance(motion: Motion, tracks: Sequence[Track], predictions: Sequence[Prediction]) -> list[Floats]:
    """Measured minus predicted displacement of each window (B - 1, 3), in units of what chance makes of it."""
    return [r / motion.noise.of(t) for t, r in zip(tracks, residuals(tracks, predictions), strict=True)]


def windows_in_time(tracks: Sequence[Track], left: Sequence[Floats], scale: AsinhNorm, ax: Axes) -> Axes:
    """A box for each window (B - 1,) from its beginning to its end, coloured; grey where there is none."""
    ends = [track.time[track.boundaries] for track in tracks]
    values = np.concatenate(left)
    begin, end = np.concatenate([e[:-1] for e in ends]), np.concatenate([e[1:] for e in ends])
    line = np.repeat(np.arange(len(tracks)), [len(value) for value in left])
    sides = np.stack([begin, end, end, begin], axis=1), line[:, None] + 0.46 * np.array([-1, -1, 1, 1])
    there = np.isfinite(values)
    boxes = PolyCollection(list(np.stack(sides, axis=2)[there]), facecolors=ANGLE_MAP(scale(values[there])), lw=0)
    boxes.set_rasterized(True)
    ax.add_collection(boxes)
    ax.set_facecolor(FAINT)
    longest = max(float(t.time[-1]) for t in tracks)
    ax.hlines([first - 0.5 for first, _, _ in _settings(tracks)[1:]], 0, longest, color=INK, lw=0.6)
    ax.set_xlim(0, longest)
    ax.set_ylim(len(tracks) - 0.5, -0.5)
    return ax


def _settings(tracks: Sequence[Track]) -> list[tuple[int, int, str]]:
    """Of each setting: the first line, how many, and its name."""
    counts = [(setting, len(list(repeats))) for setting, repeats in groupby(t.recording.setting for t in tracks)]
    ends = accumulate(count for _, count in counts)
    return [(end - count, count, setting_name(setting)) for (setting, count), end in zip(counts, ends, strict=True)]


def setting_name(setting: tuple[str, float]) -> str:
    """As `gait01, 4.26 s`."""
    return f"{setting[0]}, {setting[1]:.3g} s" if setting[1] else setting[0]
