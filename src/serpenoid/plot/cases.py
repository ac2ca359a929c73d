"""What one robust gait does in each of its cases: the centre's path, and the objective."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from serpenoid.plot.style import CHAIN_MAP, RED, dress, figure
from serpenoid.plot.world import targets

if TYPE_CHECKING:
    from serpenoid.optimise.solution import Solution


def cases_figure(solution: Solution) -> Figure:
    """Paths of the centre on the left, objectives on the right, a colour for every case."""
    fig = figure(8.6, 3.6)
    paths, bars = fig.subplots(1, 2, width_ratios=[3, 2])
    cases = solution.cases
    colours = CHAIN_MAP(np.linspace(0, 1, len(cases)))
    for case, colour in zip(cases, colours, strict=True):
        paths.plot(*case.trajectory.poses[:, :2].T, color=colour, label=case.name)
        paths.plot(*case.trajectory.poses[-1, :2], "s", color=colour, markersize=5)
    targets(solution.problem, paths)
    paths.set_aspect("equal", adjustable="datalim")
    dress(paths, "The centre's path in every case", "x [body lengths]", "y [body lengths]")
    bars.barh(range(len(cases)), [case.value for case in cases], color=colours, height=0.55)
    bars.axvline(solution.cost, color=RED, linewidth=1.0)
    bars.set_yticks(range(len(cases)), [case.name for case in cases])
    bars.invert_yaxis()
    robust = solution.problem.task.robust
    words = f"{'Mean' if robust and robust.over == 'mean' else 'Worst'} {solution.cost:.4f}".replace("-", "−")
    dress(bars, words, "objective", "")
    return fig
