"""Fit the anisotropy ratio (and what else is asked for) to a campaign, with intervals.

    serpenoid fit recordings/2024-09-foam
    serpenoid fit recordings/2024-09-foam --parameter anisotropy_ratio --parameter end_weight

Two ways: the eps of least RMS between measured and simulated displacement-time curves, trial by trial, as in the paper;
and maximum likelihood through the step equations, with shape noise and pose noise together, trial by trial and all
trials together. Answers to "how sure?": camera noise alone; robust to errors that last (what is left is not noise);
by the spread of trials, where they differ by more than chance. K has the widest of them. Simulations use the *measured*
shapes on the recording's own frames. A fitted eps holds for one kind of dissipation element only. Writes fit.json and
figures. What data do not determine has an interval and no value (null in fit.json).

Exit code 1: data do not determine a number that was asked for, or a fit did not converge, or ran into a bound where the
model does not follow the data.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from serpenoid.cli import campaigns, options
from serpenoid.cli.claim import sign
from serpenoid.wording import counted

if TYPE_CHECKING:
    from serpenoid.compare.calibrate import Calibration
    from serpenoid.measure.load import Campaign
    from serpenoid.model import Model

UNTOLD = "not determined"


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `fit`."""
    campaigns.add_campaign(parser)
    help_line = "what to fit (repeatable; default anisotropy_ratio): anisotropy_ratio, end_weight, front_weight"
    parser.add_argument("--parameter", action="append", metavar="NAME", help=help_line)
    begin = "eps where the fit begins, held where it is not fitted (default: the campaign's [medium])"
    campaigns.add_model(parser, begin)
    options.add_output(parser, "results/<campaign>/fit-<hash>")


def run(args: argparse.Namespace) -> int:
    """Fit, write, report."""
    from serpenoid.compare.calibrate import calibrate
    from serpenoid.compare.complaints import failed
    from serpenoid.compare.parameters import start_values
    from serpenoid.compare.records import calibration_record
    from serpenoid.compare.start import neutral_model
    from serpenoid.files.writing import provenance, write_json
    from serpenoid.measure.usage import said_once, total, usage

    names = tuple(args.parameter or ("anisotropy_ratio",))
    campaign = campaigns.read(args)
    campaigns.refuse_elements(args, campaign)
    model = neutral_model(campaign, args.anisotropy_ratio, args.dissipation)
    start_values(names, model)
    folder = campaigns.folder(args, args.campaign, "fit", names, model.medium.model_dump())
    with options.progress_bar(args, "fitting", len(campaign.trials) + 1) as advance:
        calibration = calibrate(campaign, model, names, lambda done, total, name: advance(done, name))
        advance(len(campaign.trials) + 1)
    record = calibration_record(calibration, model.medium.dissipation)
    used = total(usage(trial) for trial in campaign.trials)
    notes = said_once((trial.name, trial.notes) for trial in campaign.trials)
    record |= {
        "used_s": used.used_s,
        "dropped_s": used.dropped_s,
        "notes": notes,
        "campaign": campaign.file.name,
        "source": campaign.file.source,
        "provenance": provenance(),
    }
    sign(args)
    write_json(folder / "fit.json", record)
    if not args.no_figures:
        draw(folder, campaign, model, calibration)
    complaints = calibration.together.warnings
    said = [f"seconds           {used}", *(f"note              {note}" for note in notes)]
    said += [f"warning           {complaint}" for complaint in complaints]
    options.report(args, record, [*lines(calibration, model), *said, f"written to        {folder}"], folder)
    if args.quiet or args.json:
        for complaint in complaints:
            options.complain(complaint)
    return int(failed(calibration.together.solution, model) or not calibration.together.determined.all())


def lines(calibration: Calibration, model: Model) -> list[str]:
    """The summary: all trials together, mean over trials, best RMS, and K = 1 / eps."""
    import numpy as np

    from serpenoid.compare.calibrate import drag_ratio, robust_intervals
    from serpenoid.compare.intervals import within
    from serpenoid.compare.records import best_rms_told

    together = calibration.together
    robusts = robust_intervals(together, model)
    spreads = within(together.names, model, together.values, together.spread_half)
    found = [f"{model.where_drag_acts}, {counted(len(calibration.trials), 'trial')}"]
    for i, name in enumerate(calibration.names):
        value, (low, high), robust = together.values[i], together.interval[i], robusts[i]
        known = bool(together.determined[i])
        found += [
            f"{name}",
            f"  all together    {f'{value:.6g}' if known else UNTOLD}   95 % {low:.6g} .. {high:.6g} (noise), "
            f"{robust[0]:.6g} .. {robust[1]:.6g} (robust)",
        ]
        if np.isfinite(spread := spreads[i]).all():
            found.append(
                f"  trials differ   by more than chance: 95 % {spread[0]:.6g} .. {spread[1]:.6g} by their spread"
            )
        if known and len(calibration.trials) > 1:
            low, high = calibration.mean_interval[i]
            text = f"95 % {low:.6g} .. {high:.6g}, SD {calibration.spread[i]:.2g}"
            found.append(f"  mean of trials  {calibration.mean[i]:.6g}   {text}")
    if "anisotropy_ratio" in calibration.names:
        ratio, least, most = drag_ratio(together, model)
        shown = UNTOLD if np.isnan(ratio) else f"{ratio:.4g}"
        found.append(f"K = 1 / eps       {shown}   95 % {least:.4g} .. {most:.4g} (the widest of these)")
    if "anisotropy_ratio" in calibration.names and best_rms_told(calibration):
        spread = f", SD {calibration.spread_best_rms:.2g}" if len(calibration.trials) > 1 else ""
        bound = ", at a bound" if any(fit.at_bound for fit in calibration.trials) else ""
        mean = f"{calibration.mean_best_rms:.6g} (mean of trials{spread}{bound})"
        found += [
            f"best-RMS eps      {mean}, as in the paper; the answer is K, by all motion:",
            "                  this one is by the distance from the start alone, which noise of shapes draws aside,",
            "                  and more so of a body that turns",
        ]
    return [*found, f"what is left      {together.noise_scale:.2f} times the measurement noise"]


def draw(folder: Path, campaign: Campaign, model: Model, calibration: Calibration) -> None:
    """calibration, and the paper's displacement figure for the first trial."""
    import numpy as np

    from serpenoid.compare.calibrate import HIGHEST, LOWEST, displacement_curve, rms_of
    from serpenoid.compare.parameters import changed
    from serpenoid.compare.segments import trial_segments
    from serpenoid.plot.calibration import calibration_figure, displacement_for_eps
    from serpenoid.plot.figures import save
    from serpenoid.plot.style import figure

    save(calibration_figure(calibration, model), folder, "calibration")
    first = calibration.trials[0]
    trial = next(t for t in campaign.trials if t.name == first.trial)
    segment = max(trial_segments(trial), key=lambda s: len(s.time_s))

    def at(eps: float) -> Model:
        return changed(model, ("anisotropy_ratio",), np.array([eps]))

    centre = first.best_rms_eps
    lowest, highest = model.medium.limits(LOWEST, HIGHEST)
    grid = np.geomspace(max(centre / 4, lowest), min(centre * 4, highest), 25)
    curves = np.array([displacement_curve(at(eps), segment) for eps in grid])
    rms = np.array([rms_of(at(eps), (segment,)) for eps in grid])
    measured = np.hypot(*(segment.smooth_poses - segment.smooth_poses[0]).T[:2])
    best = (centre, displacement_curve(at(centre), segment))
    fig = figure(7.4, 4.4)
    fig.suptitle(first.trial, x=0.01, ha="left", fontsize="medium")
    displacement_for_eps(segment.time_s - segment.time_s[0], measured, grid, curves, rms, best, fig.add_subplot())
    save(fig, folder, "displacement-for-eps")
