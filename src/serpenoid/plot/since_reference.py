"""By how much joint angles and paths differ from those of the reference, beside what repeats differ by.

Axes reach as far as the noise level of what is compared, at least: many readings together tell smaller differences
apart, but what is drawn over the whole of a panel should be more than noise of one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from serpenoid.plot.diagnosis_ladder import MOST_TICKS, UNITS
from serpenoid.plot.diagnosis_trials import setting_name
from serpenoid.plot.room import settle
from serpenoid.plot.style import BLUE, GREY, INK, SMALL, dress, figure

if TYPE_CHECKING:
    from serpenoid.diagnose.stages.ladder import Step


NOISE = {"joints": "actuation", "paths": "motion"}  # panel -> stage of the ladder whose noise level it is held against


def since_reference_figure(found: dict[str, Any], ladder: Sequence[Step] = ()) -> Figure:
    """Joint by joint, and setting by setting; ladder: what tells noise levels, where it has these stages."""
    levels = {step.error.name: step.error.noise_level for step in ladder}
    gaits = found["gaits"]
    fig = figure(8.6, max(2.6, 0.9 + 0.24 * len(gaits)))
    axes = fig.subplots(1, 2, squeeze=False)
    joints, paths = axes.flat
    again = found["joints_repeats_rad"] or [None] * len(found["joints_rad"])
    numbers = range(1, len(found["joints_rad"]) + 1)
    scale, unit = UNITS["rad"]
    joints.bar(numbers, [scale * x for x in found["joints_rad"]], color=BLUE, width=0.62, label="from the reference")
    _level(joints.hlines, [scale * x if x is not None else None for x in again], numbers)
    joints.set_xticks(list(numbers)[:: -(-len(numbers) // MOST_TICKS)])
    _noise(joints.axhline, levels.get(NOISE["joints"]), scale)
    dress(joints, "", "joint", f"RMS of joint angles [{unit}]")
    scale, unit = UNITS["m"]
    known = [g for g in gaits if g["path_m"] is not None]
    at = range(len(known))
    paths.barh(at, [scale * g["path_m"] for g in known], color=BLUE, height=0.62)
    _level(paths.vlines, [None if g["repeats_m"] is None else scale * g["repeats_m"] for g in known], at)
    _noise(paths.axvline, levels.get(NOISE["paths"]), scale)
    paths.set_yticks(at, [setting_name((g["gait"], g["cycle_duration_s"])) for g in known], fontsize=SMALL)
    paths.invert_yaxis()
    paths.xaxis.set_major_locator(MaxNLocator(nbins=5))
    dress(paths, "", f"RMS of paths [{unit}]", "")
    for ax, way in ((joints, "x"), (paths, "y")):
        ax.grid(visible=False, axis=way)
    fig.legend(*_legend(joints), loc="upper left", ncols=3, frameon=False, fontsize=SMALL)
    settle(fig, axes, above=0.3)
    return fig


def _level(lines: Any, sizes: Sequence[float | None], at: Sequence[int]) -> None:
    """What repeats differ by, where anything was played twice."""
    for size, place in zip(sizes, at, strict=True):
        if size is not None:
            lines(size, place - 0.42, place + 0.42, color=INK, lw=1.0, linestyles="--", label="between repeats")


def _noise(line: Any, level: float | None, scale: float) -> None:
    """The noise level, within the axis whatever else is there."""
    if level is not None:
        line(scale * level, color=GREY, lw=1.0, ls=":", label="noise level")


def _legend(ax: Axes) -> tuple[list[Any], list[str]]:
    """One entry a name."""
    named = dict(zip(*reversed(ax.get_legend_handles_labels()), strict=True))
    return list(named.values()), list(named)
