"""A study's folder: compare.json, comparison.csv, figures, report.html."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from serpenoid.compare import report
from serpenoid.compare.records import COMPARISON_HEADER, comparison_row, plain, ratio_record
from serpenoid.compare.study import Study
from serpenoid.compare.three import Comparison
from serpenoid.compare.transport import by_coefficient
from serpenoid.files.writing import provenance, write_csv, write_json
from serpenoid.measure.load import Campaign
from serpenoid.measure.usage import total, usage

ANIMATED = 12  # cycles in the report's animation: the first of every gait


def study_record(study: Study, campaign: Campaign, origin: str) -> dict[str, Any]:
    """Everything as JSON values."""
    medium = study.model.medium
    return plain(
        {
            "campaign": campaign.file.name,
            "source": campaign.file.source,
            "anisotropy_ratio": medium.anisotropy_ratio,
            "anisotropy_ratio_origin": origin,
            "dissipation": medium.dissipation,
            "gaits": list(study.gaits),
            "displacement_body_lengths": study.displacement,
            "ratios": [ratio_record(s) for s in study.ratios],
            "comparisons": [dict(zip(COMPARISON_HEADER, comparison_row(c), strict=True)) for c in study.comparisons],
            "cost_of_transport": [vars(point) for point in study.costs],
            "cycles": [vars(c) for c in study.cycles],
            "power": None if study.power is None else vars(study.power),
            "used_s": total(map(usage, campaign.trials)).used_s,
            "dropped_s": total(map(usage, campaign.trials)).dropped_s,
            "notes": list(study.notes),
            "provenance": provenance(),
        }  # fmt: skip
    )


def write_study(
    folder: Path, study: Study, campaign: Campaign, record: dict[str, Any], figures: bool,
    progress: Callable[[int, str], None],
) -> None:  # fmt: skip
    """Numbers, then (unless switched off) figures and the report."""
    write_json(folder / "compare.json", record)
    write_csv(folder / "comparison.csv", COMPARISON_HEADER, [comparison_row(c) for c in study.comparisons])
    if not figures:
        return
    drawn = _draw(folder, study, progress)
    path, origin = folder / "report.html", record["anisotropy_ratio_origin"]
    report.write_report(path, study, campaign, origin, drawn)


def _draw(folder: Path, study: Study, progress: Callable[[int, str], None]) -> dict[str, tuple[Path, str]]:
    """All figures: name -> (SVG file, caption)."""
    from serpenoid.plot import comparison as plots
    from serpenoid.plot.figures import save
    from serpenoid.plot.style import figure

    drawn: dict[str, tuple[Path, str]] = {}

    def keep(fig: Any, name: str, caption: str) -> None:
        save(fig, folder, name)
        drawn[name] = (folder / f"{name}.svg", caption)

    for done, c in enumerate(_one_per_gait(study)):
        progress(done, c.trial)
        name = f"compare-{c.trial}-{c.cycle + 1}"
        keep(plots.comparison_figure(c), name, f"{c.trial}, cycle {c.cycle + 1}: paths, displacement, residuals")
    if study.ratios:
        if len(study.gaits) > 2:  # of two there is one quotient, and the summary says it
            maps = plots.heat_maps(list(study.ratios), list(study.gaits))
            keep(maps, "ratios", "Quotients Xi of the performance ratios")
        fig = figure(4.6, 4.4)
        plots.scatter(study.displacement, fig.add_subplot())
        keep(fig, "ratios-scatter", "Predicted against measured displacement of every gait")
    families = by_coefficient(study.costs)
    if families:
        fig = figure(6.4, 4.2)
        plots.cost_curves(families, fig.add_subplot())
        keep(fig, "cost", "Cost of transport against c; stars mark the minima")
    if study.power is not None:
        rate = np.array([c.dissipation_rate for c in study.cycles])
        power = np.array([c.power_W for c in study.cycles])
        fig = figure(6.0, 4.0)
        plots.power_line(rate, power, study.power.idle_W, study.power.coefficient_W, fig.add_subplot())
        keep(fig, "power", "Electrical power against the model's dissipation rate")
    return drawn


def _one_per_gait(study: Study) -> list[Comparison]:
    firsts: dict[str, Comparison] = {}
    for comparison in study.comparisons:
        firsts.setdefault(comparison.gait, comparison)
    return list(firsts.values())[:ANIMATED]
