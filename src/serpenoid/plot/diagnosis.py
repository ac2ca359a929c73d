"""Pictures of a diagnosis: paths before and after, the ladder, where and when residuals are, the ranking."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from serpenoid.body import Floats
from serpenoid.diagnose.data.used import length_unit
from serpenoid.diagnose.residuals.maps import on_floor, windows
from serpenoid.diagnose.since_reference import since_reference
from serpenoid.group import accumulate, relative
from serpenoid.parallel import in_processes, limited
from serpenoid.plot import diagnosis_ladder, diagnosis_maps, diagnosis_ranking, diagnosis_trials
from serpenoid.plot.both import save
from serpenoid.plot.joints import joint_angles, joint_bar
from serpenoid.plot.room import settle
from serpenoid.plot.since_reference import since_reference_figure
from serpenoid.plot.style import BLUE, INK, NORMAL, ORANGE, SMALL, Colour, dress, figure, fill_equal, in_turn

if TYPE_CHECKING:
    from serpenoid.diagnose.diagnose import Diagnosis
    from serpenoid.diagnose.inference.search.select import Selection
    from serpenoid.diagnose.stages.ladder import Step

COLUMNS = (4, 3)
PARTS = {"actuation": "joints", "observation": "markers"}
Jobs = dict[str, Callable[[], Figure]]
Style = Mapping[str, Any]
THROUGHOUT: Style = {"ls": "-", "lw": 0.8, "marker": "o", "ms": 2.0}
AT_ENDS: Style = {"ls": ":", "lw": 0.8, "marker": "o", "ms": 2.8}  # only there is known where a prediction leads
LABELS = {"measured": INK, "baseline": ORANGE, "extended": BLUE}


def draw_shapes(folder: Path, steps: Sequence[Step]) -> list[str]:
    """Joint by joint and marker by marker: what the ladder's steps from command to markers show. One after the other:
    while the motion is judged nobody waits for them, and no core is free."""
    with limited(1):
        parts = [s for s in steps if s.error.name in PARTS]
        return _draw(folder, {PARTS[s.error.name]: partial(diagnosis_ladder.parts_figure, s) for s in parts})


def draw_motion(folder: Path, found: Selection) -> list[str]:
    """What the search for effects alone shows, so that it can be drawn before all is judged; names of the figures."""
    w = windows(found.motion, found.null.predictions, found.best.predictions)
    extended, pieces = bool(found.best.effects), found.motion.tracks[0].recording.body.pieces
    # what takes longest is begun first
    jobs: Jobs = {"residuals": lambda: diagnosis_maps.residuals_figure(w, extended)}
    if extended:
        jobs["residuals-left"] = lambda: diagnosis_maps.left_figure(w)
    kinds = [("baseline", found.null.predictions), ("extended", found.best.predictions)][: 1 + extended]
    jobs["residuals-in-time"] = lambda: diagnosis_trials.trials_figure(found.motion, kinds)
    jobs["along-body"] = lambda: diagnosis_maps.body_figure(w, extended, found.scores, pieces)
    if on_floor(w, w.before):  # some square was visited often enough
        jobs["on-floor"] = lambda: diagnosis_maps.floor_figure(w, extended)
    if diagnosis_ranking.ranked(found):  # something gains, or was chosen
        jobs["ranking"] = lambda: diagnosis_ranking.ranking_figure(found)
    return _draw(folder, jobs)


def draw_rest(folder: Path, d: Diagnosis) -> list[str]:
    """All other figures of a diagnosis."""
    jobs: Jobs = {"paths": lambda: paths_figure(d), "ladder": lambda: diagnosis_ladder.ladder_figure(d.ladder)}
    since = since_reference(d)
    if since is not None and since["joints_rad"]:
        jobs["since-reference"] = lambda: since_reference_figure(since, d.ladder)
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
    columns = columns_of(len(settings))
    rows = -(-len(settings) // columns)
    fig = figure(9.6, 0.5 + 1.9 * rows)
    axes = fig.subplots(rows, columns, squeeze=False)
    for ax, setting in zip(axes.flat, settings, strict=False):
        paths(d, setting, ax)
    for ax in axes.flat[len(settings) :]:
        ax.set_axis_off()
    shown = [n for n in LABELS if n != "extended" or d.extension.effects]
    style = {n: THROUGHOUT if n == "measured" else AT_ENDS for n in shown}
    handles = [axes.flat[0].plot([], [], color=LABELS[n], label=n, **style[n])[0] for n in shown]
    handles += axes.flat[0].plot([], [], ".", color=INK, ms=4, label="dots: where windows end")
    if len(tracks) > len(settings):
        what = "later repeats (paler)" if d.drag_ratio is None else "later parts (paler)"
        handles += axes.flat[0].plot([], [], color=in_turn(INK, 1, 2), lw=0.8, label=what)
    fig.legend(handles=handles, loc="upper left", ncols=5, frameon=False, fontsize=NORMAL)
    settle(fig, axes, above=0.3, title=0.27)
    return fig


def columns_of(settings: int) -> int:
    """Panels beside each other: the number that leaves the fewest places empty, the larger of two."""
    return min(settings, *COLUMNS, key=lambda n: (n > max(COLUMNS), -settings % n, -n))


def paths(d: Diagnosis, setting: tuple[str, float], ax: Axes) -> Axes:
    """Centroid of all repeats of one setting: measured, and predicted by fits to the other gaits; later ones paler."""
    drawn = (("baseline", d.held_out[0]), ("extended", d.held_out[1]))
    tracks = d.motion.selection.motion.tracks
    scale, unit = diagnosis_ladder.UNITS[length_unit(tracks)]
    own = [i for i, track in enumerate(tracks) if track.recording.setting == setting]
    for repeat, i in reversed(list(enumerate(own))):
        colours = {name: in_turn(colour, repeat, len(own)) for name, colour in LABELS.items()}
        first = tracks[i].first_seen
        for name, predictions in drawn:
            if name == "baseline" or d.extension.effects:
                path = accumulate(np.nan_to_num(predictions[i].displacement[first:]), np.zeros(3))
                _path(ax, scale * path, colours[name], AT_ENDS, range(len(path)))
        ends = tracks[i].boundaries[first:] - tracks[i].boundaries[first]
        poses = tracks[i].poses[tracks[i].boundaries[first] :]
        _path(ax, scale * relative(poses[0], poses), colours["measured"], THROUGHOUT, ends)
    dress(ax, "", f"x [{unit}]", f"y [{unit}]")
    ax.set_title(diagnosis_trials.setting_name(setting), fontsize=SMALL, loc="left", color=INK, y=1.0)
    fill_equal(ax)
    ax.xaxis.set_major_locator(MaxNLocator(nbins=4))
    return ax


def _path(ax: Axes, path: Floats, colour: Colour, style: Style, ends: Sequence[int]) -> None:
    """A dot at the end of every window, a large one at the last."""
    ax.plot(*path[:, :2].T, color=colour, markevery=list(ends), **style)
    x, y = path[-1, :2]
    ax.scatter(x, y, s=14, color=colour, zorder=2)


def table_figure(table: Floats) -> Figure:
    """Joint angles of a table (T, m) over the cycle."""
    fig = figure(7.4, 2.9)
    ax = fig.add_subplot()
    joint_angles(table, ax, title="")
    joint_bar(ax, table.shape[1])
    return fig
