"""Pictures of a calibration: displacement for a range of eps, trial by trial values, profile, what is left."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from serpenoid.body import Floats
from serpenoid.compare.calibrate import Calibration, robust_intervals
from serpenoid.compare.parameters import bounds
from serpenoid.model import Model
from serpenoid.plot.beside import name_levels
from serpenoid.plot.style import BLUE, FAINT, GREY, INK, ORANGE, RED, SMALL, colour_bar, dress, figure, legend_above

RMS_MAP = LinearSegmentedColormap.from_list("rms", [RED, "#F3D9C9", "#FFFFFF"])


def displacement_for_eps(
    time_s: Floats, measured: Floats, eps: Floats, curves: Floats, rms: Floats, best: tuple[float, Floats], ax: Axes
) -> Axes:
    """Measured displacement (R,) over simulated ones (E, R), redder where their RMS (E,) is small."""
    order = np.argsort(-rms)
    scale = max(float(rms.max()), 1e-12)
    for index in order:
        if index + 1 < len(eps):
            ax.fill_between(time_s, curves[index], curves[index + 1], color=RMS_MAP(rms[index] / scale), lw=0)
    for index in range(0, len(eps), 3):
        ax.plot(time_s, curves[index], color=GREY, lw=0.5)
    ax.plot(time_s, best[1], color="#F0C400", lw=3.2, label=f"best RMS, eps = {best[0]:.4g}")
    ax.plot(time_s, measured, color=BLUE, lw=1.4, label="measured")
    colour_bar(ax, RMS_MAP, 0, scale, "RMS error [body lengths]", pad=0.1, aspect=30)
    dress(ax, "", "time [s]", "distance from the start [body lengths]")
    legend_above(ax, 2)
    name_levels(curves[::3, -1], [f"{value:.2g}" for value in eps[::3]], ax, float(time_s[-1]), GREY)
    return ax


def trial_values(calibration: Calibration, model: Model, ax: Axes) -> Axes:
    """Every trial's estimate with its interval and its best-RMS eps; that of all together as a band."""
    names = [f.trial for f in calibration.trials]
    rows = np.arange(len(names))
    together = calibration.together
    ax.axvspan(*together.interval[0], color=BLUE, alpha=0.18, lw=0)
    ax.axvline(together.values[0], color=BLUE, lw=1.2, label="all trials together, 95 %")
    values = np.array([f.estimate.values[0] for f in calibration.trials])
    robust = np.array([robust_intervals(f.estimate, model)[0] for f in calibration.trials])
    noise = np.array([f.estimate.interval[0] for f in calibration.trials])
    ax.hlines(rows, *robust.T, color=FAINT, lw=5, zorder=1, label="95 %, robust")
    ax.hlines(rows, *noise.T, color=INK, lw=1.2, label="likelihood, 95 %")
    ax.plot(values, rows, "o", color=INK, ms=4)
    if calibration.names[0] == "anisotropy_ratio":
        ax.plot([f.best_rms_eps for f in calibration.trials], rows, "D", color=ORANGE, ms=4, label="best RMS")
    (least,), (most,) = bounds(calibration.names[:1], model)
    low, high = ax.get_xlim()
    ax.set_xlim(max(low, least), min(high, most))  # what it can be
    ax.set_yticks(rows, names)
    ax.set_ylim(len(names) - 0.4, -0.6)
    dress(ax, "", calibration.names[0].replace("_", " "), "")
    legend_above(ax, 2)
    return ax


def profile(calibration: Calibration, ax: Axes) -> Axes:
    """Chi-square above its minimum along the first number, with the 95 % level."""
    if len(calibration.profile):
        values, chi2 = calibration.profile.T
        ax.plot(values, chi2 - min(float(chi2.min()), 0.0), "o-", color=BLUE, ms=3, lw=1.4)
    ax.axhline(3.84, color=GREY, lw=1, ls=(0, (3, 2)))
    ax.text(0.99, 3.95, "95 %", transform=ax.get_yaxis_transform(), ha="right", fontsize=SMALL, color=GREY)
    ax.ticklabel_format(axis="x", useOffset=False)
    ax.tick_params(axis="x", rotation=30)
    return dress(ax, "Profile", calibration.names[0].replace("_", " "), "chi squared above least")


def left_over(calibration: Calibration, ax: Axes) -> Axes:
    """Autocorrelation of the white defects, with the band a right model stays in."""
    lags = np.arange(1, len(calibration.together.autocorrelation) + 1)
    count = sum(w.defect.size for w in calibration.together.solution.segments)
    band = 2 / np.sqrt(count)
    ax.axhspan(-band, band, color=BLUE, alpha=0.2, lw=0)
    ax.vlines(lags, 0, calibration.together.autocorrelation, color=INK, lw=1.4)
    ax.axhline(0, color=GREY, lw=0.8)
    low = min(-0.1, 1.1 * float(calibration.together.autocorrelation.min()))
    ax.set_ylim(low, max(0.1, 1.1 * float(calibration.together.autocorrelation.max())))
    return dress(
        ax,
        f"What is left: {calibration.together.noise_scale:.2f} \N{MULTIPLICATION SIGN} noise",
        "lag [frames]",
        "autocorrelation",
    )


def calibration_figure(calibration: Calibration, model: Model) -> Figure:
    """Trial values beside profile and autocorrelation."""
    fig = figure(9.4, max(4.2, 1.6 + 0.28 * len(calibration.trials)))
    grid = fig.add_gridspec(2, 2, width_ratios=[1.3, 1])
    trial_values(calibration, model, fig.add_subplot(grid[:, 0]))
    profile(calibration, fig.add_subplot(grid[0, 1]))
    left_over(calibration, fig.add_subplot(grid[1, 1]))
    return fig
