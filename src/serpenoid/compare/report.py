"""The HTML report of a study: tables, figures, and an animation one can scrub."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from serpenoid.compare.study import Study
from serpenoid.compare.three import Comparison
from serpenoid.measure.load import Campaign
from serpenoid.report.animated import Animated, Layer, animation_data
from serpenoid.report.pages import Picture, Table, write_page

LAYERS = {
    "Exp": ("Exp: measured", "#009E73", 16),
    "Sim": ("Sim: commanded shapes, simulated", "#E69F00", 10),
    "Resim": ("Resim: measured shapes, simulated", "#0072B2", 4),
}


def write_report(
    path: Path, study: Study, campaign: Campaign, origin: str, drawn: Mapping[str, tuple[Path, str]]
) -> None:  # fmt: skip
    """Write the report. origin: of the anisotropy ratio; drawn: name -> (SVG file, caption)."""
    write_page(
        path,
        "compare.html",
        title=campaign.file.name,
        lead=_lead(study, campaign, origin),
        displacements=_displacements(study),
        cycles=len(study.comparisons),
        errors=_errors(study),
        ratios=_ratios(study) if study.ratios else None,
        costs=_costs(study) if study.costs else None,
        notes=Table(["note"], [[note] for note in study.notes]) if study.notes else None,
        pictures={
            "ratios": _pictures(drawn, "ratios"),
            "costs": _pictures(drawn, "cost", "power"),
            "trials": _pictures(drawn, "compare-"),
        },
        animation=animation_data([animated(c) for c in study.comparisons]),
    )


def animated(comparison: Comparison) -> Animated:
    """One passage as the page's animation takes it."""
    paths = {"Exp": comparison.exp, "Sim": comparison.sim, "Resim": comparison.resim}
    layers = {
        name: Layer(*LAYERS[name], bodies=path.vertices, path=path.poses[:, :2])
        for name, path in paths.items()
        if path is not None
    }
    return Animated(f"{comparison.trial}, cycle {comparison.cycle + 1}", comparison.time_s, layers)


def _lead(study: Study, campaign: Campaign, origin: str) -> list[str]:
    medium = study.model.medium
    lead = [campaign.file.description, f"Data: {campaign.file.source}" if campaign.file.source else ""]
    lead.append(
        f"Anisotropy ratio {medium.anisotropy_ratio:.6g} ({origin}), {study.model.where_drag_acts}. "
        "Exp: measured. Sim: commanded shapes simulated. Resim: measured shapes simulated. "
        "Displacements in body lengths, over a cycle and half the pause after it."
    )
    return [text for text in lead if text]


def _pictures(drawn: Mapping[str, tuple[Path, str]], *prefixes: str) -> list[Picture]:
    return [Picture.of(*drawn[name]) for name in drawn if name.startswith(prefixes)]


def _displacements(study: Study) -> Table:
    classes = [name for name in ("Exp", "Sim", "Resim") if name in study.displacement]
    rows = [[gait, *(float(study.displacement[k][i]) for k in classes)] for i, gait in enumerate(study.gaits)]
    return Table(["gait", *classes], rows)


def _errors(study: Study) -> Table:
    header = ["trial", "cycle", "part", "forward", "left", "turn [rad]", "path RMS"]
    rows: list[list[Any]] = []
    for c in study.comparisons:
        for part, words in (("whole", "Exp - Sim"), ("actuation", "Resim - Sim"), ("motion", "Exp - Resim")):
            error = c.error(part)
            if error:
                rows.append([c.trial, c.cycle + 1, words, *error.values()])
    return Table(header, rows)


def _ratios(study: Study) -> Table:
    header = [
        "pair",
        "mean",
        "SD",
        "typical ratio",
        "from",
        "to",
        "SD of its ln",
        "from",
        "to",
        "rank correlation",
        "wrong pairs",
    ]
    rows = [
        [s.pair, s.mean, s.std, s.bias, *s.bias_interval, s.s, *s.s_interval, s.rank_correlation,
         f"{len(s.wrong_pairs)} of {s.pair_count}"] for s in study.ratios
    ]  # fmt: skip
    return Table(header, rows)


def _costs(study: Study) -> Table:
    rows = [[p.gait, "" if p.dissipation_coefficient is None else p.dissipation_coefficient, p.mean, p.std, p.trials]
            for p in study.costs]  # fmt: skip
    return Table(["gait", "c", "cost of transport", "SD", "trials"], rows)
