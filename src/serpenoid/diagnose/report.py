"""The HTML report: verdict with paths before and after, the ladder, residuals, ranking, what to do."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from serpenoid.compare.report import figure, table, write_report
from serpenoid.diagnose.reference import words
from serpenoid.effects.catalogue import find

TITLES = {
    "paths": "Measured paths (ink) with the baseline's (orange) and the extended model's (blue)",
    "ladder": "The ladder: what is left on each rung, in units of its floor",
    "residuals": "Residual motion per window along the phase of the cycle, before and after, in standard deviations",
    "ranking": "Candidates by their gain on held-out gaits, to first order",
}


def write_pages(folder: Path, record: dict[str, Any]) -> None:
    """report.html, from the record and the figures that are in the folder."""
    lead = [f"Verdict: {record['verdict']}."]
    for e in record["effects"]:
        kind = find(e["name"])
        where = "" if e["place"] is None else f" at {kind.place} {e['place']}"
        lead.append(f"{e['name']}{where}: {kind.looks_like}. What to do: {kind.what_to_do}.")
    lead += [f"Not accounted for: {text}." for text in record["residual_pattern"]]
    if record["reference"]:
        lead += [f"{text}." for text in words(record["reference"])]
    sections = [("Before and after", _figure(folder, "paths") + _gain(record)), ("Evidence", _parameters(record))]
    sections += [("The ladder", _figure(folder, "ladder")), ("Residuals", _figure(folder, "residuals"))]
    sections += [("Ranking", _figure(folder, "ranking")), ("Alternatives", _alternatives(record))]
    write_report(folder / "report.html", f"Diagnosis of {record['campaign']}", lead, sections, [])


def _figure(folder: Path, name: str) -> str:
    return figure(folder / f"{name}.svg", TITLES[name])


def _gain(record: dict[str, Any]) -> str:
    rows = []
    for name, g in record["gain"].items():
        rows.append([name, g["before"], g["after"], "{:.4g} .. {:.4g}".format(*g["after_interval"])])
    return table(["on held-out gaits", "before", "after", "95 %"], rows)


def _parameters(record: dict[str, Any]) -> str:
    rows = []
    for e in record["effects"]:
        for name, p in e["parameters"].items():
            low, high = p["interval"]
            place = "" if e["place"] is None else str(e["place"])
            rows.append([e["name"], place, name, p["value"], p["unit"], str(low), str(high)])
    return (
        table(["effect", "place", "parameter", "value", "unit", "low", "high"], rows) if rows else "<p>No effect.</p>"
    )


def _alternatives(record: dict[str, Any]) -> str:
    if not record["alternatives"]:
        return "<p>None: the data exclude every other entry of the catalogue that was tried.</p>"
    rows = [
        [e["name"], "" if e["place"] is None else str(e["place"]), str(e["parameters"])] for e in record["alternatives"]
    ]
    text = table(["effect", "place", "fitted as well with"], rows)
    e = record["next_experiment"]
    if e is None:
        return text
    return text + f"<p>Next experiment: play {e['joint_table']} with {e['cycle_duration_s']:.3g} s per cycle.</p>"
