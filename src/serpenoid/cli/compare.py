"""Lay measured, simulated and resimulated motion over each other: Exp, Sim, Resim.

    serpenoid compare recordings/2024-09-foam --anisotropy-ratio 0.1865
    serpenoid compare problems/campaigns/lamprey.toml

Exp is what the cameras saw, Sim the commanded shapes simulated, Resim the measured shapes simulated. Exp - Sim splits
into an actuation part (Resim - Sim) and a motion part (Exp - Resim) that add up to it. With no anisotropy ratio on the
command line or in campaign.toml, it is fitted to all trials first. Writes compare.json, comparison.csv, figures (heat
maps of performance ratios, cost of transport) and report.html, one file with everything and an animation to scrub.
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from serpenoid.cli import campaigns, options
from serpenoid.cli.claim import sign

if TYPE_CHECKING:
    from serpenoid.compare.study import Study


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of `compare`."""
    campaigns.add_campaign(parser)
    campaigns.add_model(parser)
    options.add_output(parser, "results/<campaign>/compare-<hash>")


def run(args: argparse.Namespace) -> int:
    """Compare, write, report."""
    from serpenoid.compare.start import compared_model
    from serpenoid.compare.study import NOTHING, compare_campaign
    from serpenoid.compare.write import study_record, write_study
    from serpenoid.errors import InputError

    campaign = campaigns.read(args)
    campaigns.refuse_elements(args, campaign)
    folder = campaigns.folder(args, args.campaign, "compare", args.anisotropy_ratio, args.dissipation)
    model, origin = compared_model(campaign, args.anisotropy_ratio, args.dissipation)
    with options.progress_bar(args, "comparing", len(campaign.trials)) as advance:
        study = compare_campaign(campaign, model, lambda done, total, name: advance(done, name))
        advance(len(campaign.trials))
    if not study.comparisons:
        raise InputError("; ".join([NOTHING, *study.notes]))
    record = study_record(study, campaign, origin)
    sign(args)
    with options.progress_bar(args, "drawing", len(study.comparisons)) as advance:
        write_study(folder, study, campaign, record, not args.no_figures, advance)
        advance(len(study.comparisons))
    options.report(args, record, [*lines(study, origin), f"written to        {folder}"], folder)
    return 0


def lines(study: Study, origin: str) -> list[str]:
    """The summary."""
    medium = study.model.medium
    found = [f"anisotropy ratio  {medium.anisotropy_ratio:.6g} ({origin}), {study.model.where_drag_acts}"]
    found += [f"{'gait':<24}{'Exp':>9}{'Resim':>9}{'Sim':>9}   [body lengths]"] if study.gaits else []
    for i, gait in enumerate(study.gaits):
        cells: list[Any] = [f"{study.displacement[k][i]:9.4f}" if k in study.displacement else f"{'-':>9}"
                            for k in ("Exp", "Resim", "Sim")]  # fmt: skip
        share = study.displacement["Resim"][i] / study.displacement["Exp"][i]
        found.append(f"{gait:<24}{''.join(cells)}   Resim / Exp = {share:.3f}")
    for s in study.ratios:
        found.append(
            f"{s.pair:<12} Xi: mean {s.mean:.4f}, SD {s.std:.4f}; typical ratio {s.bias:.3f}, SD of its "
            f"logarithm {s.s:.4f}; rank correlation {s.rank_text}, {len(s.wrong_pairs)} of {s.pair_count} pairs wrong"
        )
    for point in study.costs:
        c = "" if point.dissipation_coefficient is None else f" at c = {point.dissipation_coefficient:g}"
        scatter = "one trial" if point.trials == 1 else f"SD {point.std:.2g}, {point.trials} trials"
        found.append(f"cost of transport {point.gait}{c}: {point.mean:.3f} ({scatter})")
    if study.power is not None:
        p = study.power
        found.append(
            f"power             {p.idle_W:.3f} W idle + {p.coefficient_W:.4g} x dissipation rate (r2 {p.r2:.4f})"
        )
    return found + [f"note: {note}" for note in study.notes]
