"""The picture that Jupyter shows of a result."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from matplotlib.figure import Figure


def preview(result: Any) -> Figure | None:
    """By the result's class; None where there is nothing to draw."""
    return PREVIEWS[type(result).__name__](result) if type(result).__name__ in PREVIEWS else None


def _motion(result: Any) -> Figure | None:
    from serpenoid.plot.figures import motion_figure

    return motion_figure(result.trajectory, result.problem) if result.trajectory.status.ok else None


def _recording(result: Any) -> Figure | None:
    from serpenoid.plot.recording import trial_figure

    return next((trial_figure(t) for t in result.campaign.trials if t.motion is not None), None)


def _calibration(result: Any) -> Figure | None:
    from serpenoid.plot.calibration import calibration_figure

    return calibration_figure(result.calibration, result.model)


def _comparison(result: Any) -> Figure | None:
    from serpenoid.plot.comparison import comparison_figure

    return comparison_figure(result.study.comparisons[0])


def _diagnosis(result: Any) -> Figure | None:
    from serpenoid.plot.diagnosis import paths_figure

    return paths_figure(result.diagnosis)


PREVIEWS: dict[str, Callable[[Any], Figure | None]] = {
    "Simulation": _motion,
    "Solution": _motion,
    "MultiStart": lambda found: _motion(found.best),
    "Measured": _recording,
    "Fitted": _calibration,
    "Compared": _comparison,
    "Diagnosed": _diagnosis,
}
